#include "batten/io/pictures.h"

#include <dlfcn.h>
#include <vtkActor.h>
#include <vtkAutoInit.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkContourFilter.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkScalarBarActor.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/io/vtk_files.h"
#include "batten/io/whole_file.h"

// VTK finds its drawing code by these.
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)

namespace batten {
namespace fs = std::filesystem;
namespace {

using Colour = Vec3;
const Colour kBody(0.70, 0.775, 0.86), kLine(0.83, 0.21, 0.10), kContour(0.13, 0.17, 0.24),
    kParameter(0.30, 0.38, 0.50), kMesh(0.25, 0.30, 0.38), kText(0.14, 0.16, 0.20), kTop(1, 1, 1),
    kBottom(0.80, 0.825, 0.855);

/// Drawn this much larger and averaged down: smooth edges with any driver.
constexpr int kOversampling = 2;

// ---------------------------------------------------------------------------------- camera

/// Orthonormal: right, up, and towards the camera.
struct ViewAxes {
  Vec3 right, up, towards;
  explicit ViewAxes(const PictureScene& scene) {
    const double degree = std::numbers::pi / 180;
    const double a = scene.azimuth * degree, e = scene.elevation * degree;
    right = {std::cos(a), std::sin(a), 0};
    towards = {std::sin(a) * std::cos(e), -std::cos(a) * std::cos(e), std::sin(e)};
    up = towards.cross(right);
  }
};

/// A part of the window in pixels, from its lower left corner.
struct Frame {
  double width, height;  // of the viewport
  double top, bottom;    // kept free for text
  double unit;           // 1 at 1600 × 1000: sizes of text and lines go with it
};

struct Fit {
  Vec3 focus;
  double pixel;  // length of a pixel in the model
};

Fit fit(const std::vector<Vec3>& points, const ViewAxes& axes, const Frame& frame, double zoom) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& p : points) {
    const Vec3 q(axes.right.dot(p), axes.up.dot(p), axes.towards.dot(p));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  const double margin = 0.06;
  const double width = frame.width * (1 - 2 * margin);
  const double height = (frame.height - frame.top - frame.bottom) * (1 - 2 * margin);
  const Vec3 extent = high - low;
  double pixel = std::max(extent.x() / width, extent.y() / height);
  if (!(pixel > 0)) pixel = 1 / width;
  pixel /= zoom;
  const Vec3 middle = (low + high) / 2;
  const double shift = pixel * (frame.top - frame.bottom) / 2;
  return {middle.x() * axes.right + (middle.y() + shift) * axes.up + middle.z() * axes.towards,
          pixel};
}

// ---------------------------------------------------------------------------------- geometry

std::vector<Vec3> points_of(vtkPolyData& data) {
  std::vector<Vec3> points(static_cast<size_t>(data.GetNumberOfPoints()));
  for (size_t p = 0; p < points.size(); ++p)
    data.GetPoint(static_cast<vtkIdType>(p), points[p].data());
  return points;
}

/// Where the surface is singular it has no normal; for the light, the facets around give one.
void complete_normals(vtkPolyData& data, const std::vector<Vec3>& points) {
  vtkDataArray& normals = *data.GetPointData()->GetNormals();
  std::vector<Vec3> sum(points.size(), Vec3::Zero());
  vtkIdType count;
  const vtkIdType* corner;
  for (data.GetPolys()->InitTraversal(); data.GetPolys()->GetNextCell(count, corner);) {
    const Vec3 area =
        (points[corner[1]] - points[corner[0]]).cross(points[corner[2]] - points[corner[0]]);
    for (int i = 0; i < 3; ++i) sum[corner[i]] += area;
  }
  for (size_t p = 0; p < points.size(); ++p) {
    double n[3];
    normals.GetTuple(static_cast<vtkIdType>(p), n);
    if (n[0] == 0 && n[1] == 0 && n[2] == 0)
      normals.SetTuple(static_cast<vtkIdType>(p), sum[p].normalized().eval().data());
  }
}

/// The part of `data` with these lines or facets; points and their data are shared.
vtkSmartPointer<vtkPolyData> part(vtkPolyData& data, vtkCellArray* lines, vtkCellArray* facets) {
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(data.GetPoints());
  result->GetPointData()->ShallowCopy(data.GetPointData());
  if (lines) result->SetLines(lines);
  if (facets) result->SetPolys(facets);
  return result;
}

/// Enough for smooth outlines, few enough to be drawn at once.
int facets_per_edge(const PictureScene& scene) {
  if (scene.tessellation > 0) return scene.tessellation;
  constexpr double facets = 40000;
  double triangles = 0;
  for (const auto* region : scene.regions) triangles += region->surface.mesh().triangle_count();
  return std::clamp(static_cast<int>(std::sqrt(facets / triangles)), 2, 24);
}

/// Points of the regions lie one region after the other in the order of their tessellations.
vtkSmartPointer<vtkCellArray> element_edges(const PictureScene& scene, int tessellation) {
  auto cells = vtkSmartPointer<vtkCellArray>::New();
  vtkIdType first = 0;
  for (const auto* region : scene.regions) {
    const auto [points, edges] = tessellate_with_edges(region->surface.mesh(), tessellation);
    for (const auto& edge : edges) {
      cells->InsertNextCell(static_cast<int>(edge.size()));
      for (const int p : edge) cells->InsertCellPoint(first + p);
    }
    first += static_cast<vtkIdType>(points.points.size());
  }
  return cells;
}

/// `count` lines of equal value, evenly spaced inside the range of the values.
vtkSmartPointer<vtkPolyData> iso_lines(vtkPolyData& facets, const std::vector<double>& values,
                                       int count) {
  vtkNew<vtkDoubleArray> scalars;
  for (const double value : values) scalars->InsertNextValue(value);
  const auto surface = part(facets, nullptr, facets.GetPolys());
  surface->GetPointData()->Initialize();
  surface->GetPointData()->SetScalars(scalars);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  vtkNew<vtkContourFilter> filter;
  filter->SetInputData(surface);
  filter->ComputeScalarsOff();
  // A flat surface has no contours, only rounding.
  const double size = std::max(std::abs(*low), std::abs(*high));
  if (*high - *low > 1e-12 * size)
    for (int i = 0; i < count; ++i) filter->SetValue(i, *low + (i + 0.5) / count * (*high - *low));
  filter->Update();
  return filter->GetOutput();
}

// ---------------------------------------------------------------------------------- actors

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

/// Lines on the surface, moved towards the camera by a few pixels: parallel projection shows no
/// shift, and the facets cannot cover them.
void add_thin_lines(vtkRenderer& renderer, vtkPolyData* lines, const Colour& colour, double width,
                    const Vec3& offset) {
  const auto drawn = actor(nullptr, lines, colour);
  drawn->GetProperty()->LightingOff();
  drawn->GetProperty()->SetLineWidth(static_cast<float>(std::max(1.6, width * kOversampling)));
  drawn->SetPosition(offset.x(), offset.y(), offset.z());
  renderer.AddActor(drawn);
}

void add_light(vtkRenderer& renderer, double x, double y, double z, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(x, y, z);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

/// VTK's own font knows Latin letters only and passes over all others.
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

/// Pixels of the picture.
double text_width(vtkTextProperty& property, const std::string& text) {
  int box[4] = {0, 0, 0, 0};
  constexpr int dpi = 72;
  vtkTextRenderer::GetInstance()->GetBoundingBox(&property, text, box, dpi);
  return static_cast<double>(box[1] - box[0] + 1) / kOversampling;
}

/// One line of text that fits into `width`: smaller, then shorter.
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
    // Whole UTF-8 characters only.
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

// ---------------------------------------------------------------------------------- fields

/// The smallest number of two digits that is not below x.
double rounded_up(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / power * (1 - 1e-9)) * power;
}

vtkSmartPointer<vtkLookupTable> diverging_colours(double limit) {
  vtkNew<vtkColorTransferFunction> colours;
  colours->SetColorSpaceToDiverging();
  colours->AddRGBPoint(-1, 0.230, 0.299, 0.754);
  colours->AddRGBPoint(0, 0.865, 0.865, 0.865);
  colours->AddRGBPoint(1, 0.706, 0.016, 0.150);
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  constexpr int entries = 511;
  table->SetNumberOfTableValues(entries);
  for (int i = 0; i < entries; ++i) {
    double rgb[3];
    colours->GetColor(2.0 * i / (entries - 1) - 1, rgb);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  table->SetRange(-limit, limit);
  return table;
}

/// Largest magnitude between the 2nd and the 98th percentile, rounded up.
double field_limit(vtkDataArray& values) {
  std::vector<double> sorted;
  for (vtkIdType i = 0; i < values.GetNumberOfTuples(); ++i)
    if (const double v = values.GetTuple1(i); std::isfinite(v)) sorted.push_back(v);
  if (sorted.empty()) return 1;
  std::sort(sorted.begin(), sorted.end());
  const size_t cut = sorted.size() / 50;
  const double limit = std::max(std::abs(sorted[cut]), std::abs(sorted[sorted.size() - 1 - cut]));
  return limit > 1e-300 ? rounded_up(limit) : 1;
}

/// Colours, numbers below them, the title above: 100 units high.
void add_scalar_bar(vtkRenderer& renderer, vtkLookupTable* table, const std::string& title,
                    const Frame& frame) {
  const double width = std::min(0.5 * frame.width, 640 * frame.unit);
  const double bottom = frame.bottom - 100 * frame.unit;
  const double text = std::max(10.0, 20 * frame.unit);
  vtkNew<vtkScalarBarActor> bar;
  bar->SetLookupTable(table);
  bar->SetOrientationToHorizontal();
  bar->SetTextPositionToPrecedeScalarBar();
  bar->SetTextPad(static_cast<int>(6 * frame.unit * kOversampling));
  bar->SetNumberOfLabels(5);
  bar->SetLabelFormat("%.3g");
  bar->UnconstrainedFontSizeOn();
  set_font(*bar->GetLabelTextProperty(), text);
  bar->SetMaximumNumberOfColors(512);
  bar->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  bar->SetPosition((frame.width - width) / 2 / frame.width, bottom / frame.height);
  bar->SetWidth(width / frame.width);
  bar->SetHeight(64 * frame.unit / frame.height);
  bar->SetBarRatio(0.36);
  renderer.AddActor2D(bar);
  add_text(renderer, title, frame.width / 2, bottom + 64 * frame.unit + 0.9 * text, text, width,
           true);
}

// ---------------------------------------------------------------------------------- scenes

void check(const PictureScene& scene) {
  const std::string who = "picture '" + scene.title + "': ";
  const auto expect = [&](bool good, const std::string& what, double found,
                          const std::string& expected) {
    if (!good)
      throw InputError(who + "found " + what + " " + number(found) + ", expected " + expected);
  };
  if (scene.regions.empty()) throw InputError(who + "there is no region to draw");
  expect(scene.tessellation >= 0 && scene.tessellation <= 64, "tessellation", scene.tessellation,
         "0 to 64");
  expect(scene.contours >= 0 && scene.contours <= 1000, "contours", scene.contours, "0 to 1000");
  expect(scene.parameter_lines >= 0 && scene.parameter_lines <= 1000, "parameter lines",
         scene.parameter_lines, "0 to 1000");
  expect(scene.zoom > 0 && std::isfinite(scene.zoom), "zoom", scene.zoom, "a number above 0");
  expect(std::abs(scene.elevation) <= 90, "elevation", scene.elevation, "-90 to 90 degrees");
  expect(std::isfinite(scene.azimuth), "azimuth", scene.azimuth, "degrees");
  if (scene.contours > 0)
    expect(scene.contour_direction.allFinite() && scene.contour_direction.norm() > 0,
           "contour direction of length", scene.contour_direction.norm(), "a length above 0");
}

void add_surface(vtkRenderer& renderer, const PictureScene& scene, vtkPolyData& data,
                 const Frame& frame) {
  const auto facets = part(data, nullptr, data.GetPolys());
  const auto body = actor(nullptr, facets, kBody);
  vtkProperty& look = *body->GetProperty();
  look.SetInterpolationToPhong();
  look.SetAmbient(0.16);
  look.SetDiffuse(0.86);
  look.SetSpecular(0.18);
  look.SetSpecularPower(40);
  if (scene.field != PictureScene::Field::None) {
    const bool mean = scene.field == PictureScene::Field::Mean;
    const char* array = mean ? "Mean_curvature" : "Gauss_curvature";
    facets->GetPointData()->SetActiveScalars(array);
    const auto table = diverging_colours(field_limit(*facets->GetPointData()->GetScalars()));
    body->GetMapper()->ScalarVisibilityOn();
    body->GetMapper()->SetLookupTable(table);
    body->GetMapper()->UseLookupTableScalarRangeOn();
    body->GetMapper()->InterpolateScalarsBeforeMappingOn();
    look.SetAmbient(0.3);
    look.SetDiffuse(0.7);
    look.SetSpecular(0.06);
    add_scalar_bar(renderer, table, mean ? "Mean curvature" : "Gauss curvature", frame);
  }
  renderer.AddActor(body);
}

void add_iso_lines(vtkRenderer& renderer, const PictureScene& scene, vtkPolyData& data,
                   const std::vector<Vec3>& points, double width, const Vec3& offset) {
  std::vector<double> values(points.size());
  vtkDataArray& uv = *data.GetPointData()->GetArray("uv");
  for (int component = 0; scene.parameter_lines > 0 && component < 2; ++component) {
    for (size_t p = 0; p < values.size(); ++p)
      values[p] = uv.GetComponent(static_cast<vtkIdType>(p), component);
    add_thin_lines(renderer, iso_lines(data, values, scene.parameter_lines), kParameter, width,
                   offset);
  }
  if (scene.contours == 0) return;
  const Vec3 direction = scene.contour_direction.normalized();
  for (size_t p = 0; p < values.size(); ++p) values[p] = direction.dot(points[p]);
  add_thin_lines(renderer, iso_lines(data, values, scene.contours), kContour, width, offset);
}

/// Fills a renderer whose viewport has the given size in pixels.
void draw(vtkRenderer& renderer, const PictureScene& scene, double width, double height,
          bool caption_below) {
  const double unit = std::sqrt(width / 1600 * height / 1000);
  const double text = std::max(13.0, 28 * unit);
  const double row = scene.title.empty() ? 0 : 2 * text;
  const bool bar = scene.field != PictureScene::Field::None;
  const double below = caption_below ? row : 0;
  const Frame frame{width, height, caption_below ? 0 : row, below + (bar ? 116 * unit : 0), unit};

  const int tessellation = facets_per_edge(scene);

  renderer.GradientBackgroundOn();
  renderer.SetBackground(kBottom.data());
  renderer.SetBackground2(kTop.data());
  // Key from the upper left, head light, two fills: no side that faces the viewer stays dark.
  add_light(renderer, -0.6, 0.8, 0.9, 0.58);
  add_light(renderer, 0, 0, 1, 0.38);
  add_light(renderer, 0.9, -0.1, 0.5, 0.20);
  add_light(renderer, -0.2, -0.9, 0.6, 0.26);

  const auto data = to_poly_data(scene.regions, {{}, tessellation});
  const std::vector<Vec3> points = points_of(*data);
  complete_normals(*data, points);
  const ViewAxes axes(scene);
  const Fit view = fit(points, axes, frame, scene.zoom);
  const Vec3 offset = 4 * view.pixel * axes.towards;

  add_surface(renderer, scene, *data, frame);
  if (scene.mesh)
    add_thin_lines(renderer, part(*data, element_edges(scene, tessellation), nullptr), kMesh,
                   0.9 * unit, offset);
  add_iso_lines(renderer, scene, *data, points, 1.2 * unit, offset);
  if (scene.lines && data->GetNumberOfLines() > 0) {
    vtkNew<vtkTubeFilter> tubes;
    const auto chains = part(*data, data->GetLines(), nullptr);
    chains->GetPointData()->Initialize();
    tubes->SetInputData(chains);
    tubes->SetRadius(2.6 * unit * view.pixel);
    tubes->SetNumberOfSides(16);
    tubes->CappingOn();
    const auto drawn = actor(tubes->GetOutputPort(), nullptr, kLine);
    drawn->GetProperty()->SetSpecular(0.3);
    drawn->GetProperty()->SetSpecularPower(25);
    drawn->GetProperty()->SetAmbient(0.25);
    drawn->SetPosition(offset.x(), offset.y(), offset.z());
    renderer.AddActor(drawn);
  }
  const double x = caption_below ? width / 2 : 1.2 * text;
  const double y = caption_below ? 0.9 * text : height - 1.2 * text;
  add_text(renderer, scene.title, x, y, text, width - 2.4 * text, caption_below);

  vtkCamera& camera = *renderer.GetActiveCamera();
  const Vec3 position = view.focus + axes.towards * (view.pixel * (width + height));
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(view.focus.x(), view.focus.y(), view.focus.z());
  camera.SetPosition(position.x(), position.y(), position.z());
  camera.SetViewUp(axes.up.x(), axes.up.y(), axes.up.z());
  camera.SetParallelScale(view.pixel * height / 2);
  renderer.ResetCameraClippingRange();
}

// ---------------------------------------------------------------------------------- window

/// Kept for the life of the process: making one costs more than drawing a picture.
vtkRenderWindow& window() {
  static const vtkSmartPointer<vtkRenderWindow> the_window = [] {
    auto made = vtkSmartPointer<vtkRenderWindow>::New();
    made->SetOffScreenRendering(1);
    made->SetMultiSamples(4);
    return made;
  }();
  return *the_window;
}

/// Renderers that leave the window with this object, so that it can serve again.
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

vtkSmartPointer<vtkImageData> averaged_down(const vtkUnsignedCharArray& pixels, int width,
                                            int height) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(width, height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* out = static_cast<unsigned char*>(image->GetScalarPointer());
  const unsigned char* in = const_cast<vtkUnsignedCharArray&>(pixels).GetPointer(0);
  constexpr int n = kOversampling;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = n * n / 2;
        for (int dy = 0; dy < n; ++dy)
          for (int dx = 0; dx < n; ++dx)
            sum += in[(static_cast<size_t>(n * y + dy) * (n * width) + (n * x + dx)) * 3 + c];
        *out++ = static_cast<unsigned char>(sum / (n * n));
      }
  return image;
}

void check(const PictureSize& size) {
  for (const int pixels : {size.width, size.height})
    if (pixels < 64 || pixels > 4096)
      throw InputError("found a picture size of " + std::to_string(size.width) + " x " +
                       std::to_string(size.height) + ", expected 64 to 4096 pixels");
}

void draw_sheet(const fs::path& path, const std::vector<PictureScene>& scenes, int columns,
                bool captions_below, const PictureSize& size) {
  check(size);
  for (const auto& scene : scenes) check(scene);
  require_display();
  WholeFile file(path);
  vtkRenderWindow& canvas = window();
  const int rows = (static_cast<int>(scenes.size()) + columns - 1) / columns;
  const double cell_width = static_cast<double>(size.width) / columns;
  const double cell_height = static_cast<double>(size.height) / rows;
  const double gap = captions_below ? 3 : 0;
  const double width = cell_width - 2 * gap, height = cell_height - 2 * gap;
  if (width < 32 || height < 32)
    throw InputError("found " + std::to_string(scenes.size()) +
                     " pictures on one sheet, expected room for 32 pixels each way");
  canvas.SetSize(size.width * kOversampling, size.height * kOversampling);
  vtkNew<vtkUnsignedCharArray> pixels;
  {
    Viewports viewports(canvas);
    viewports.add().SetBackground(1, 1, 1);  // behind all others
    for (int i = 0; i < static_cast<int>(scenes.size()); ++i) {
      const int row = i / columns, column = i % columns;
      vtkRenderer& renderer = viewports.add();
      const double left = column * cell_width + gap, top = row * cell_height + gap;
      renderer.SetViewport(left / size.width, 1 - (top + height) / size.height,
                           (left + width) / size.width, 1 - top / size.height);
      draw(renderer, scenes[static_cast<size_t>(i)], width, height, captions_below);
    }
    canvas.Render();
    canvas.GetPixelData(0, 0, size.width * kOversampling - 1, size.height * kOversampling - 1, 0,
                        pixels);
  }
  if (pixels->GetNumberOfValues() !=
      vtkIdType{3} * kOversampling * kOversampling * size.width * size.height)
    throw NoSolutionError(path.string() + ": VTK drew nothing");
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName(file.temporary().c_str());
  writer->SetInputData(averaged_down(*pixels, size.width, size.height));
  writer->Write();
  if (writer->GetErrorCode() != vtkErrorCode::NoError)
    throw InputError(path.string() + ": cannot write this file: " +
                     vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode()));
  file.commit();
}

}  // namespace

void require_display() {
  static std::string good;  // the server that was asked last
  const std::string advice = "; run under xvfb-run -a, or where an X server is";
  const char* set = std::getenv("DISPLAY");
  const std::string name = set ? set : "";
  if (name.empty()) throw InputError("no display: VTK draws only with an X server" + advice);
  if (name == good) return;
  void* library = dlopen("libX11.so.6", RTLD_NOW | RTLD_LOCAL);
  if (!library) throw InputError("no display: libX11.so.6 is missing" + advice);
  const auto open = reinterpret_cast<void* (*)(const char*)>(dlsym(library, "XOpenDisplay"));
  const auto query = reinterpret_cast<int (*)(void*, const char*, int*, int*, int*)>(
      dlsym(library, "XQueryExtension"));
  // The connection stays: servers start anew, and refuse others meanwhile, when the last one ends.
  static void* display = nullptr;
  display = open && query ? open(nullptr) : nullptr;
  if (!display)
    throw InputError("no display: the X server '" + name + "' does not answer" + advice);
  int opcode, event, error;
  if (!query(display, "GLX", &opcode, &event, &error))
    throw InputError("no display: the X server '" + name + "' has no OpenGL (GLX)" + advice);
  good = name;
}

void draw_picture(const fs::path& path, const PictureScene& scene, const PictureSize& size) {
  draw_sheet(path, {scene}, 1, false, size);
}

void draw_contact_sheet(const fs::path& path, const std::vector<PictureScene>& scenes, int columns,
                        const PictureSize& size) {
  if (scenes.empty()) throw InputError("a contact sheet needs at least one scene");
  if (columns < 1)
    throw InputError("found " + std::to_string(columns) + " columns, expected 1 or more");
  draw_sheet(path, scenes, std::min(columns, static_cast<int>(scenes.size())), true, size);
}

}  // namespace batten
