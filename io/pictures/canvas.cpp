// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/canvas.h"

#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/image.h"

// Registers VTK's rendering back ends.
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace batten {
namespace fs = std::filesystem;
namespace detail {
namespace {

const Colour kTop(1, 1, 1), kBottom(0.80, 0.825, 0.855);

/// Supersampling factor: pictures are rendered this many times larger and averaged down, which
/// gives smooth edges with any driver.
constexpr int kOversampling = 2;

void add_light(vtkRenderer& renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

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

void check(const PictureSize& size) {
  for (const int pixels : {size.width, size.height})
    if (pixels < 64 || pixels > 4096)
      throw InputError("found a picture size of " + std::to_string(size.width) + " x " +
                       std::to_string(size.height) + ", expected 64 to 4096 pixels");
}

}  // namespace

std::vector<Vec3> points_of(vtkPolyData& data) {
  std::vector<Vec3> points(static_cast<size_t>(data.GetNumberOfPoints()));
  for (size_t p = 0; p < points.size(); ++p)
    data.GetPoint(static_cast<vtkIdType>(p), points[p].data());
  return points;
}

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

vtkSmartPointer<vtkActor> body(vtkPolyData* facets, const Colour& colour) {
  auto result = actor(nullptr, facets, colour);
  vtkProperty& look = *result->GetProperty();
  look.SetInterpolationToPhong();
  look.SetAmbient(0.16);
  look.SetDiffuse(0.86);
  look.SetSpecular(0.18);
  look.SetSpecularPower(40);
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
  drawn->GetProperty()->SetSpecular(0.3);
  drawn->GetProperty()->SetSpecularPower(25);
  drawn->GetProperty()->SetAmbient(0.25);
  drawn->SetPosition(offset.x(), offset.y(), offset.z());
  renderer.AddActor(drawn);
}

void add_lights(vtkRenderer& renderer) {
  renderer.GradientBackgroundOn();
  renderer.SetBackground(kBottom.data());
  renderer.SetBackground2(kTop.data());
  add_light(renderer, -0.6, 0.8, 0.9, 0.58);
  add_light(renderer, 0, 0, 1, 0.38);
  add_light(renderer, 0.9, -0.1, 0.5, 0.20);
  add_light(renderer, -0.2, -0.9, 0.6, 0.26);
}

namespace {

double unit_of(double width, double height) { return std::sqrt(width / 1600 * height / 1000); }
double title_pixels(double width, double height) {
  return std::max(13.0, 28 * unit_of(width, height));
}

}  // namespace

Viewport viewport_of(double width, double height, const std::string& title, bool caption_below,
                     double bar_height) {
  const double unit = unit_of(width, height);
  const double row = title.empty() ? 0 : 2 * title_pixels(width, height);
  return {width, height, caption_below ? 0 : row, (caption_below ? row : 0) + bar_height * unit,
          unit};
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

void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Viewport& viewport) {
  const double width = std::min(0.5 * viewport.width, 640 * viewport.unit);
  const double bottom = viewport.bottom - 100 * viewport.unit;
  const double text = std::max(10.0, 20 * viewport.unit);
  vtkNew<vtkScalarBarActor> bar;
  bar->SetLookupTable(table);
  bar->SetOrientationToHorizontal();
  bar->SetTextPositionToPrecedeScalarBar();
  bar->SetTextPad(static_cast<int>(6 * viewport.unit * kOversampling));
  bar->SetNumberOfLabels(5);
  bar->SetLabelFormat("%.3g");
  bar->UnconstrainedFontSizeOn();
  set_font(*bar->GetLabelTextProperty(), text);
  bar->SetMaximumNumberOfColors(512);
  bar->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  bar->SetPosition((viewport.width - width) / 2 / viewport.width, bottom / viewport.height);
  bar->SetWidth(width / viewport.width);
  bar->SetHeight(64 * viewport.unit / viewport.height);
  bar->SetBarRatio(0.36);
  renderer.AddActor2D(bar);
  add_text(renderer, title, viewport.width / 2, bottom + 64 * viewport.unit + 0.9 * text, text,
           width, true);
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
    canvas.GetPixelData(0, 0, size.width * kOversampling - 1, size.height * kOversampling - 1, 0,
                        pixels);
  }
  if (pixels->GetNumberOfValues() !=
      vtkIdType{3} * kOversampling * kOversampling * size.width * size.height)
    throw NoSolutionError("VTK drew nothing");
  return averaged_down(*pixels, size.width, size.height);
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

namespace batten::detail {

ViewAxes::ViewAxes(double azimuth, double elevation, int up_axis) {
  const double degree = std::numbers::pi / 180;
  const double a = azimuth * degree, e = elevation * degree;
  const auto turned = [&](double x, double y, double z) {
    Vec3 v;
    v[(up_axis + 1) % 3] = x;
    v[(up_axis + 2) % 3] = y;
    v[up_axis] = z;
    return v;
  };
  right = turned(std::cos(a), std::sin(a), 0);
  towards = turned(std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e));
  up = towards.cross(right);
}

ViewAxes::ViewAxes(const Vec3& towards_camera) : towards(towards_camera.normalized()) {
  const Vec3 above = std::abs(towards.z()) > std::sqrt(0.5) ? Vec3::UnitY() : Vec3::UnitZ();
  right = above.cross(towards).normalized();
  up = towards.cross(right);
}

ViewAxes best_view(const std::vector<Vec3>& points) {
  const PrincipalAxes plane = principal_axes(points);
  Vec3 normal = plane.axes.col(0);
  // A straight line defines no plane: use the default view, made perpendicular to the line.
  if (plane.values[1] <= 1e-9 * plane.values[2]) {
    const Vec3 along = plane.axes.col(2), usual = ViewAxes(-30, 30).towards;
    normal = usual - usual.dot(along) * along;
    if (normal.norm() < 1e-6) normal = along.unitOrthogonal();
  }
  // From above; from the front (-y) if the plane is steep, from the right if it faces sideways.
  const double side = std::abs(normal.z()) > std::sqrt(0.5) ? normal.z()
                      : std::abs(normal.y()) > 0.3          ? -normal.y()
                                                            : normal.x();
  return ViewAxes(side < 0 ? Vec3(-normal) : normal);
}

Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Viewport& viewport,
        double zoom) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& p : points) {
    const Vec3 q(axes.right.dot(p), axes.up.dot(p), axes.towards.dot(p));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  const double margin = 0.06;
  const double width = viewport.width * (1 - 2 * margin);
  const double height = (viewport.height - viewport.top - viewport.bottom) * (1 - 2 * margin);
  const Vec3 extent = high - low;
  double pixel = std::max(extent.x() / width, extent.y() / height);
  if (!(pixel > 0)) pixel = 1 / width;
  pixel /= zoom;
  const Vec3 middle = (low + high) / 2;
  const double shift = pixel * (viewport.top - viewport.bottom) / 2;
  return {middle.x() * axes.right + (middle.y() + shift) * axes.up + middle.z() * axes.towards,
          pixel};
}

}  // namespace batten::detail
