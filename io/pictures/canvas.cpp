// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/canvas.h"

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/drawing_primitives.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/shading.h"

// Registers VTK's rendering back ends.
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace batten {
namespace fs = std::filesystem;
namespace detail {
namespace {

const Colour kTop(1, 1, 1), kBottom(0.885, 0.897, 0.912);

/// Supersampling factor: pictures are rendered this many times larger and averaged down, which
/// gives smooth edges with any driver.
constexpr int kOversampling = 2;

/// VTK's built-in font has Latin letters only and silently drops all others.
void set_font(vtkTextProperty& text, double pixels) {
  static const char* const file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  static const bool there = fs::exists(file);
  if (there) {
    text.SetFontFamily(VTK_FONT_FILE);
    text.SetFontFile(file);
  } else {
    text.SetFontFamilyToArial();
  }
  text.SetFontSize(std::max(1, static_cast<int>(std::lround(pixels * kOversampling))));
  text.SetColor(kText.data());
  text.BoldOff();
  text.ItalicOff();
  text.ShadowOff();
}

/// Width in pixels of the final picture.
double text_width(vtkTextProperty& property, const std::string& text) {
  int box[4] = {0, 0, 0, 0};
  constexpr int dpi = 72;
  vtkTextRenderer::GetInstance()->GetBoundingBox(&property, text, box, dpi);
  return static_cast<double>(box[1] - box[0] + 1) / kOversampling;
}

/// Kept for the lifetime of the process, because creating a window costs more than drawing a
/// picture.
vtkRenderWindow& window() {
  static const vtkSmartPointer<vtkRenderWindow> the_window = [] {
    auto made = vtkSmartPointer<vtkRenderWindow>::New();
    made->SetDisplayId(x_display());
    made->SetOffScreenRendering(1);
    made->SetMultiSamples(0);
    // The X window itself is invisible. A small one needs no buffers beside the offscreen ones.
    made->SetSize(16, 16);
    made->Start();
    return made;
  }();
  return *the_window;
}

/// Renderers that are removed from the window on destruction, so that the window can be reused.
class Viewports {
 public:
  explicit Viewports(vtkRenderWindow& canvas) : canvas_(canvas) {}
  ~Viewports() {
    for (const auto& renderer : renderers_) canvas_.RemoveRenderer(renderer);
  }
  Viewports(const Viewports&) = delete;
  Viewports& operator=(const Viewports&) = delete;
  vtkRenderer& add() {
    renderers_.push_back(vtkSmartPointer<vtkRenderer>::New());
    canvas_.AddRenderer(renderers_.back());
    return *renderers_.back();
  }
  const std::vector<vtkSmartPointer<vtkRenderer>>& all() const { return renderers_; }

 private:
  vtkRenderWindow& canvas_;
  std::vector<vtkSmartPointer<vtkRenderer>> renderers_;
};

/// Averages the supersampled pixels. VTK's rows start at the bottom.
Image averaged_down(const vtkUnsignedCharArray& pixels, int width, int height) {
  Image image{width, height, {}};
  image.rgb.reserve(size_t{3} * static_cast<size_t>(width) * height);
  const unsigned char* in = const_cast<vtkUnsignedCharArray&>(pixels).GetPointer(0);
  constexpr int n = kOversampling;
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = n * n / 2;
        for (int dy = 0; dy < n; ++dy)
          for (int dx = 0; dx < n; ++dx)
            sum += in[(static_cast<size_t>(n * y + dy) * (n * width) + (n * x + dx)) * 3 + c];
        image.rgb.push_back(static_cast<unsigned char>(sum / (n * n)));
      }
  return image;
}

/// Darkens the concave parts of what a renderer has drawn.
void occlude(Image& image, vtkRenderer& renderer, const vtkFloatArray& depths) {
  const int* origin = renderer.GetOrigin();
  const int* size = renderer.GetSize();
  vtkCamera& camera = *renderer.GetActiveCamera();
  const double* range = camera.GetClippingRange();
  const double pixel = 2 * camera.GetParallelScale() / size[1];
  const OcclusionMap map =
      ambient_occlusion(depths, image.width * kOversampling, origin[0], origin[1], size[0], size[1],
                        (range[1] - range[0]) / pixel);
  constexpr int n = kOversampling;
  for (int y = 0; y < size[1] / n; ++y)
    for (int x = 0; x < size[0] / n; ++x) {
      const float open = map.at(n * (x + 0.5), n * (y + 0.5));
      if (open >= 1) continue;
      const int row = image.height - 1 - (origin[1] / n + y);
      unsigned char* rgb =
          &image.rgb[3 * (static_cast<size_t>(row) * image.width + origin[0] / n + x)];
      for (int c = 0; c < 3; ++c)
        rgb[c] = static_cast<unsigned char>(static_cast<float>(rgb[c]) * open + 0.5F);
    }
}

void check(const PictureSize& size) {
  for (const int pixels : {size.width, size.height})
    if (pixels < 64 || pixels > 4096)
      throw InputError("found a picture size of " + std::to_string(size.width) + " x " +
                       std::to_string(size.height) + ", expected 64 to 4096 pixels");
}

}  // namespace

vtkSmartPointer<vtkActor> actor(vtkAlgorithmOutput* port, vtkPolyData* data, const Colour& colour) {
  vtkNew<vtkPolyDataMapper> mapper;
  if (port)
    mapper->SetInputConnection(port);
  else
    mapper->SetInputData(data);
  mapper->ScalarVisibilityOff();
  auto result = vtkSmartPointer<vtkActor>::New();
  result->SetMapper(mapper);
  result->GetProperty()->SetColor(colour.x(), colour.y(), colour.z());
  return result;
}

void add_thin_lines(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double width,
                    const Vec3& offset) {
  const auto drawn = actor(nullptr, lines, colour);
  drawn->GetProperty()->LightingOff();
  drawn->GetProperty()->SetLineWidth(static_cast<float>(std::max(2.2, width * kOversampling)));
  drawn->SetPosition(offset.x(), offset.y(), offset.z());
  renderer.AddActor(drawn);
}

void add_dots(vtkRenderer& renderer, vtkPolyData* points, const Colour& colour, double width) {
  const auto drawn = actor(nullptr, points, colour);
  drawn->GetProperty()->LightingOff();
  drawn->GetProperty()->SetPointSize(static_cast<float>(std::max(2.0, width * kOversampling)));
  drawn->GetProperty()->RenderPointsAsSpheresOn();
  renderer.AddActor(drawn);
}

void add_text(vtkRenderer& renderer, std::string text, double x, double y, double pixels,
              double width, bool centred) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.empty()) return;
  vtkNew<vtkTextActor> drawn;
  vtkTextProperty& property = *drawn->GetTextProperty();
  set_font(property, pixels);
  if (const double wide = text_width(property, text); wide > width)
    set_font(property, std::max(0.65 * pixels, pixels * width / wide));
  std::string shown = text;
  while (text_width(property, shown) > width && !text.empty()) {
    // Remove whole UTF-8 characters only.
    while (text.size() > 1 && (static_cast<unsigned char>(text.back()) & 0xC0) == 0x80)
      text.pop_back();
    text.pop_back();
    shown = text + "...";
  }
  drawn->SetInput(shown.c_str());
  if (centred) property.SetJustificationToCentered();
  property.SetVerticalJustificationToCentered();
  drawn->SetPosition(x * kOversampling, y * kOversampling);
  renderer.AddActor2D(drawn);
}

vtkSmartPointer<vtkActor> body(vtkPolyData* facets, const Colour& colour, Finish finish) {
  auto result = actor(nullptr, facets, colour);
  apply_finish(*result, finish);
  return result;
}

void add_tubes(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double radius,
               const Vec3& offset) {
  vtkNew<vtkTubeFilter> tubes;
  tubes->SetInputData(lines);
  tubes->SetRadius(radius);
  tubes->SetNumberOfSides(16);
  tubes->CappingOn();
  const auto drawn = actor(tubes->GetOutputPort(), nullptr, colour);
  apply_finish(*drawn, Finish::Curve);
  drawn->SetPosition(offset.x(), offset.y(), offset.z());
  renderer.AddActor(drawn);
}

void set_stage(vtkRenderer& renderer) {
  renderer.GradientBackgroundOn();
  renderer.SetBackground(kBottom.data());
  renderer.SetBackground2(kTop.data());
}

namespace {

/// Smaller pictures get relatively thicker lines and larger text.
double unit_of(double width, double height) { return std::pow(width / 1600 * height / 1000, 0.35); }
double title_pixels(double width, double height) {
  return std::max(14.0, 30 * std::pow(unit_of(width, height), 0.7));
}

}  // namespace

double label_pixels(double width, double height) { return 0.78 * title_pixels(width, height); }

Viewport viewport_of(double width, double height, const std::string& title, bool caption_below,
                     double rows) {
  const double row = title.empty() ? 0 : 2 * title_pixels(width, height);
  return {width, height, caption_below ? 0 : row,
          (caption_below ? row : 0) + rows * label_pixels(width, height), unit_of(width, height)};
}

void add_title(vtkRenderer& renderer, const std::string& title, double width, double height,
               bool caption_below) {
  const double text = title_pixels(width, height);
  const double x = caption_below ? width / 2 : 1.2 * text;
  const double y = caption_below ? 0.9 * text : height - 1.2 * text;
  add_text(renderer, title, x, y, text, width - 2.4 * text, caption_below);
}

void set_camera(vtkRenderer& renderer, const ViewAxes& axes, const Fit& view, double width,
                double height) {
  vtkCamera& camera = *renderer.GetActiveCamera();
  const Vec3 position = view.focus + axes.towards * (view.pixel * (width + height));
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(view.focus.x(), view.focus.y(), view.focus.z());
  camera.SetPosition(position.x(), position.y(), position.z());
  camera.SetViewUp(axes.up.x(), axes.up.y(), axes.up.z());
  camera.SetParallelScale(view.pixel * height / 2);
  renderer.ResetCameraClippingRange();
}

namespace {

/// Polygons in pixels, each in one colour, drawn together.
class FlatPolygons {
 public:
  FlatPolygons() { colours_->SetNumberOfComponents(3); }
  void add(const std::vector<Vec2>& corners, const Colour& colour) {
    cells_->InsertNextCell(static_cast<int>(corners.size()));
    for (const Vec2& p : corners)
      cells_->InsertCellPoint(
          points_->InsertNextPoint(p.x() * kOversampling, p.y() * kOversampling, 0));
    colours_->InsertNextTuple3(255 * colour.x(), 255 * colour.y(), 255 * colour.z());
  }
  void add_box(double left, double bottom, double width, double height, const Colour& colour) {
    const double right = left + width, top = bottom + height;
    add({{left, bottom}, {right, bottom}, {right, top}, {left, top}}, colour);
  }
  void draw(vtkRenderer& renderer) {
    vtkNew<vtkPolyData> data;
    data->SetPoints(points_);
    data->SetPolys(cells_);
    data->GetCellData()->SetScalars(colours_);
    vtkNew<vtkPolyDataMapper2D> mapper;
    mapper->SetInputData(data);
    mapper->SetScalarModeToUseCellData();
    vtkNew<vtkActor2D> drawn;
    drawn->SetMapper(mapper);
    renderer.AddActor2D(drawn);
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

std::string three_figures(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

/// The title, with the extreme values that are beyond the scale.
std::string bar_title(const std::string& title, bool below, bool above, const Range& values,
                      double limit) {
  if (!below && !above) return title;
  std::string text = title + " (";
  if (below) text += "min " + three_figures(values.first) + ", ";
  if (above) text += "max " + three_figures(values.second) + ", ";
  return text + "scale clipped at " + (below ? "±" : "") + three_figures(limit) + ")";
}

}  // namespace

void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Range& values, const Viewport& viewport) {
  const double text = label_pixels(viewport.width, viewport.height);
  const double width = std::min(0.6 * viewport.width, 30 * text), height = 0.8 * text;
  const double left = (viewport.width - width) / 2, right = left + width;
  const double bottom = viewport.bottom - (kScalarBarRows - 1.9) * text, top = bottom + height;
  const double low = table->GetRange()[0], high = table->GetRange()[1];
  const auto colour = [&](double value) {
    Colour c;
    table->GetColor(value, c.data());
    return c;
  };
  FlatPolygons bar;
  constexpr int strips = 256;
  for (int i = 0; i < strips; ++i)
    bar.add_box(left + width * i / strips, bottom, width / strips, height,
                colour(low + (i + 0.5) / strips * (high - low)));
  const double middle = bottom + height / 2, beyond = 1e-6 * (high - low);
  const bool is_below = values.first<low - beyond, is_above = values.second> high + beyond;
  if (is_below) bar.add({{left, bottom}, {left, top}, {left - height, middle}}, colour(low));
  if (is_above) bar.add({{right, bottom}, {right, top}, {right + height, middle}}, colour(high));
  const double step = round_step((high - low) / 4), tick = 0.3 * text;
  for (double k = std::ceil(low / step - 1e-6); k * step <= high + beyond; ++k) {
    const double x = left + width * (k * step - low) / (high - low);
    bar.add_box(x - 0.04 * text, bottom - tick, 0.08 * text, tick, kText);
    add_text(renderer, three_figures(k == 0 ? 0 : k * step), x, bottom - text, text, width, true);
  }
  bar.draw(renderer);
  add_text(renderer, bar_title(title, is_below, is_above, values, high), viewport.width / 2,
           top + 0.85 * text, text, viewport.width - 2 * text, true);
}

Image sheet_image(int count, int columns, bool captions_below, const PictureSize& size,
                  const std::function<void(vtkRenderer&, int, double, double)>& draw) {
  check(size);
  require_display();
  vtkRenderWindow& canvas = window();
  const int rows = (count + columns - 1) / columns;
  const double cell_width = static_cast<double>(size.width) / columns;
  const double cell_height = static_cast<double>(size.height) / rows;
  const double gap = captions_below ? 3 : 0;
  const double width = cell_width - 2 * gap, height = cell_height - 2 * gap;
  if (width < 32 || height < 32)
    throw InputError("found " + std::to_string(count) +
                     " pictures on one sheet, expected at least 32 x 32 pixels for each");
  canvas.SetSize(size.width * kOversampling, size.height * kOversampling);
  vtkNew<vtkUnsignedCharArray> pixels;
  vtkNew<vtkFloatArray> depths;
  const int right = size.width * kOversampling - 1, top_row = size.height * kOversampling - 1;
  Image image;
  {
    Viewports viewports(canvas);
    viewports.add().SetBackground(1, 1, 1);  // background of the whole sheet
    for (int i = 0; i < count; ++i) {
      const int row = i / columns, column = i % columns;
      vtkRenderer& renderer = viewports.add();
      const double left = column * cell_width + gap, top = row * cell_height + gap;
      renderer.SetViewport(left / size.width, 1 - (top + height) / size.height,
                           (left + width) / size.width, 1 - top / size.height);
      draw(renderer, i, width, height);
    }
    canvas.Render();
    canvas.GetPixelData(0, 0, right, top_row, 0, pixels);
    canvas.GetZbufferData(0, 0, right, top_row, depths);
    const vtkIdType samples = vtkIdType{right + 1} * (top_row + 1);
    if (pixels->GetNumberOfValues() != 3 * samples || depths->GetNumberOfValues() != samples)
      throw NoSolutionError("VTK drew nothing");
    image = averaged_down(*pixels, size.width, size.height);
    for (const auto& renderer : viewports.all())
      if (renderer->GetGradientBackground())  // set_stage(): a picture of surfaces
        occlude(image, *renderer, *depths);
  }
  return image;
}

void draw_sheet(const fs::path& path, int count, int columns, bool captions_below,
                const PictureSize& size,
                const std::function<void(vtkRenderer&, int, double, double)>& draw) {
  check(size);
  require_display();
  { const AtomicFile before_the_work(path); }  // checks that the file can be written
  write_png(path, sheet_image(count, columns, captions_below, size, draw));
}

}  // namespace detail
}  // namespace batten
