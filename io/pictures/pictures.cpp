// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/pictures.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/pictures/canvas.h"
#include "batten/io/pictures/drawing_primitives.h"
#include "batten/io/pictures/shading.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

using namespace detail;

/// Facets per element edge: enough for smooth outlines, few enough for fast drawing.
int facets_per_edge(const PictureScene& scene) {
  if (scene.tessellation > 0) return scene.tessellation;
  constexpr double facets = 40000;
  double triangles = 0;
  for (const auto* region : scene.regions) triangles += region->surface.mesh().triangle_count();
  const int fewest = triangles > facets ? 1 : 2;  // elements of a few pixels need no subdivision
  return std::clamp(static_cast<int>(std::sqrt(facets / triangles)), fewest, 24);
}

const char* const kValue = "Value";

bool has_scale(const PictureScene& scene) {
  using Field = PictureScene::Field;
  return scene.field == Field::Mean || scene.field == Field::Gauss || scene.field == Field::Value;
}

vtkSmartPointer<vtkPolyData> facets_of(const PictureScene& scene) {
  VtkOptions options;
  options.facets_per_edge = facets_per_edge(scene);
  options.curvatures = has_scale(scene) && scene.field != PictureScene::Field::Value;
  if (scene.field == PictureScene::Field::Value)
    options.fields = {{kValue, 1, [&](int region, const Location& where) {
                         return VecX::Constant(1, scene.value.at(region, where));
                       }}};
  return to_poly_data(scene.regions, options);
}

void check(const PictureScene& scene) {
  const std::string who = "picture '" + scene.title + "': ";
  const auto expect = [&](bool good, const std::string& what, double found,
                          const std::string& expected) {
    if (!good)
      throw InputError(who + "found " + what + " " + format_number(found) + ", expected " +
                       expected);
  };
  if (scene.regions.empty()) throw InputError(who + "found no face to draw, expected at least one");
  expect(scene.tessellation >= 0 && scene.tessellation <= 64, "tessellation", scene.tessellation,
         "0 to 64");
  expect(scene.contours >= 0 && scene.contours <= 1000, "contours", scene.contours, "0 to 1000");
  expect(scene.parameter_lines >= 0 && scene.parameter_lines <= 1000, "isocurves",
         scene.parameter_lines, "0 to 1000");
  expect(scene.zoom > 0 && std::isfinite(scene.zoom), "zoom", scene.zoom, "a number above 0");
  expect(std::abs(scene.elevation) <= 90, "elevation", scene.elevation, "-90 to 90 degrees");
  expect(std::isfinite(scene.azimuth), "azimuth", scene.azimuth, "degrees");
  expect(scene.zebra >= 0 && scene.zebra <= 1000, "zebra", scene.zebra, "0 to 1000 stripes");
  if (scene.zebra > 0) {
    expect(scene.zebra_direction.allFinite() && scene.zebra_direction.norm() > 0,
           "zebra direction of length", scene.zebra_direction.norm(), "a length above 0");
    if (scene.field != PictureScene::Field::None)
      throw InputError(who + "found both zebra stripes and a field, expected one of them");
  }
  if (scene.contours > 0)
    expect(scene.contour_direction.allFinite() && scene.contour_direction.norm() > 0,
           "contour direction of length", scene.contour_direction.norm(), "a length above 0");
}

/// Adds the angles between normals and a direction (radians) as active scalars. The result is the
/// table of their stripes.
vtkSmartPointer<vtkLookupTable> add_zebra(vtkPolyData& facets, const Vec3& direction, int stripes) {
  vtkDataArray& normals = *facets.GetPointData()->GetNormals();
  vtkNew<vtkDoubleArray> angles;
  angles->SetName("Angle");
  std::vector<double> sorted;
  for (vtkIdType p = 0; p < normals.GetNumberOfTuples(); ++p) {
    Vec3 n;
    normals.GetTuple(p, n.data());
    const Vec3 d = direction.normalized();
    angles->InsertNextValue(std::atan2(n.cross(d).norm(), n.dot(d)));
    sorted.push_back(angles->GetValue(p));
  }
  facets.GetPointData()->SetScalars(angles);
  std::sort(sorted.begin(), sorted.end());
  const size_t cut = sorted.size() / 50;
  const double from = sorted[cut], to = sorted[sorted.size() - 1 - cut];
  // A flat surface gets a single colour.
  constexpr double flat = 1e-9;
  return striped_colours(sorted.front(), std::max(sorted.back(), sorted.front() + flat), from,
                         std::max(to - from, flat * stripes) / stripes);
}

/// A light colour per facet, by face. Faces with adjacent indices get clearly different hues.
vtkSmartPointer<vtkUnsignedCharArray> region_colours(vtkPolyData& data) {
  auto colours = vtkSmartPointer<vtkUnsignedCharArray>::New();
  colours->SetNumberOfComponents(3);
  vtkDataArray& region = *data.GetCellData()->GetArray("Face");
  for (vtkIdType c = data.GetNumberOfLines(); c < region.GetNumberOfTuples(); ++c) {
    const int r = static_cast<int>(region.GetComponent(c, 0));
    constexpr double golden = 0.6180339887498949;
    const double hue = std::fmod(0.58 + r * golden, 1.0);
    const double shades[] = {0.92, 0.76, 0.85};
    double rgb[3];
    vtkMath::HSVToRGB(hue, 0.42, shades[r % 3], &rgb[0], &rgb[1], &rgb[2]);
    colours->InsertNextTuple3(255 * rgb[0], 255 * rgb[1], 255 * rgb[2]);
  }
  return colours;
}

const char* field_array(const PictureScene& scene) {
  return scene.field == PictureScene::Field::Value  ? kValue
         : scene.field == PictureScene::Field::Mean ? "Mean_curvature"
                                                    : "Gauss_curvature";
}

std::string bar_title(const PictureScene& scene) {
  if (scene.field == PictureScene::Field::Value) return scene.value.title;
  const bool mean = scene.field == PictureScene::Field::Mean;
  const std::string unit = scene.unit.empty() ? "" : " [1/" + scene.unit + (mean ? "]" : "²]");
  return (mean ? "mean curvature" : "Gaussian curvature") + unit;
}

void add_surface(vtkRenderer& renderer, const PictureScene& scene, vtkPolyData& data,
                 const Viewport& viewport) {
  const auto facets = extract_cells(data, nullptr, data.GetPolys());
  const bool scale = has_scale(scene);
  const auto drawn = body(facets, kBody, scale || scene.zebra > 0 ? Finish::Field : Finish::Paint);
  vtkMapper& mapper = *drawn->GetMapper();
  const auto colour_by = [&](vtkLookupTable* table) {
    mapper.ScalarVisibilityOn();
    mapper.SetLookupTable(table);
    mapper.UseLookupTableScalarRangeOn();
    mapper.InterpolateScalarsBeforeMappingOn();
  };
  if (scene.zebra > 0) colour_by(add_zebra(*facets, scene.zebra_direction, scene.zebra));
  if (scene.field == PictureScene::Field::Regions) {
    facets->GetCellData()->SetScalars(region_colours(data));
    mapper.ScalarVisibilityOn();
    mapper.SetScalarModeToUseCellData();
    mapper.SetColorModeToDirectScalars();
  } else if (scale) {
    const bool value = scene.field == PictureScene::Field::Value;
    facets->GetPointData()->SetActiveScalars(field_array(scene));
    vtkDataArray& values = *facets->GetPointData()->GetScalars();
    const double stated = value ? scene.value.limit : scene.field_limit;
    const double limit = stated > 0 ? stated : field_limit(values);
    const auto table = value ? sequential_colours(limit) : diverging_colours(limit);
    colour_by(table);
    add_scalar_bar(renderer, table, bar_title(scene), finite_range(values), viewport);
  }
  renderer.AddActor(drawn);
}

std::vector<double> heights(const std::vector<Vec3>& points, const Vec3& direction) {
  std::vector<double> values;
  for (const Vec3& p : points) values.push_back(direction.normalized().dot(p));
  return values;
}

void add_iso_lines(vtkRenderer& renderer, const PictureScene& scene, vtkPolyData& data,
                   const std::vector<Vec3>& points, double width, const Vec3& offset) {
  std::vector<double> values(points.size());
  vtkDataArray& uv = *data.GetPointData()->GetArray("uv");
  for (int component = 0; scene.parameter_lines > 0 && component < 2; ++component) {
    for (size_t p = 0; p < values.size(); ++p)
      values[p] = uv.GetComponent(static_cast<vtkIdType>(p), component);
    add_thin_lines(renderer, iso_lines(data, values, range_of(values), scene.parameter_lines),
                   kParameter, width, offset);
  }
  if (scene.contours == 0) return;
  values = heights(points, scene.contour_direction);
  const Range range = scene.contour_range.value_or(range_of(values));
  add_thin_lines(renderer, iso_lines(data, values, range, scene.contours), kContour, width, offset);
}

/// Fills a renderer whose viewport has the given size in pixels.
void draw(vtkRenderer& renderer, const PictureScene& scene, double width, double height,
          bool caption_below) {
  const bool bar = has_scale(scene);
  const Viewport viewport =
      viewport_of(width, height, scene.title, caption_below, bar ? kScalarBarRows : 0);
  const double unit = viewport.unit;

  set_stage(renderer);
  const auto data = facets_of(scene);
  const auto extra_curves = polylines(scene.extra_curves);
  std::vector<Vec3> points = points_of(*data);
  complete_normals(*data, points);
  std::vector<Vec3> visible_points = scene.in_view.empty() ? points : scene.in_view;
  if (scene.in_view.empty())
    for (const Vec3& p : points_of(*extra_curves)) visible_points.push_back(p);
  const ViewAxes axes(scene.azimuth, scene.elevation);
  const Fit view = fit(visible_points, axes, viewport, scene.zoom);
  const Vec3 offset = 4 * view.pixel * axes.towards;

  add_floor_shadow(renderer, *data, axes, 2);
  add_surface(renderer, scene, *data, viewport);
  if (scene.mesh)
    add_thin_lines(renderer, element_edges(scene.regions, facets_per_edge(scene)), kMesh,
                   0.9 * unit, offset);
  add_iso_lines(renderer, scene, *data, points, 1.2 * unit, offset);
  if (scene.lines && data->GetNumberOfLines() > 0) {
    const auto chains = extract_cells(*data, data->GetLines(), nullptr);
    chains->GetPointData()->Initialize();
    add_tubes(renderer, chains, bar ? kContour : kLine, 2.1 * unit * view.pixel, offset);
  }
  if (scene.lines && !scene.extra_curves.empty())
    add_tubes(renderer, extra_curves, kExtraCurve, 2.1 * unit * view.pixel, offset);
  add_title(renderer, scene.title, width, height, caption_below);
  set_camera(renderer, axes, view, width, height);
}

void draw_scenes(const fs::path& path, const std::vector<PictureScene>& scenes, int columns,
                 bool captions_below, const PictureSize& size) {
  for (const auto& scene : scenes) check(scene);
  draw_sheet(path, isize(scenes), columns, captions_below, size,
             [&](vtkRenderer& renderer, int i, double width, double height) {
               draw(renderer, scenes[i], width, height, captions_below);
             });
}

}  // namespace

void draw_picture(const fs::path& path, const PictureScene& scene, const PictureSize& size) {
  draw_scenes(path, {scene}, 1, false, size);
}

Image picture_image(const PictureScene& scene, const PictureSize& size) {
  check(scene);
  return sheet_image(1, 1, false, size,
                     [&](vtkRenderer& renderer, int, double width, double height) {
                       draw(renderer, scene, width, height, false);
                     });
}

void share_view(std::vector<PictureScene>& scenes) {
  if (scenes.empty()) return;
  const ViewAxes axes(scenes.front().azimuth, scenes.front().elevation);
  Vec3 low = Vec3::Constant(kInfinity), high = -low;
  Range range{kInfinity, -kInfinity};
  double limit = 0;
  for (PictureScene& scene : scenes) {
    check(scene);
    scene.azimuth = scenes.front().azimuth;
    scene.elevation = scenes.front().elevation;
    scene.zoom = scenes.front().zoom;
    const auto data = facets_of(scene);
    const std::vector<Vec3> points = points_of(*data);
    for (const Vec3& p : points) {
      const Vec3 seen(axes.right.dot(p), axes.up.dot(p), axes.towards.dot(p));
      low = low.cwiseMin(seen);
      high = high.cwiseMax(seen);
    }
    if (scene.contours > 0) {
      const auto [lowest, highest] = range_of(heights(points, scene.contour_direction));
      range = {std::min(range.first, lowest), std::max(range.second, highest)};
    }
    if (has_scale(scene))
      limit = std::max(limit, field_limit(*data->GetPointData()->GetArray(field_array(scene))));
  }
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back((i & 1 ? low : high)[0] * axes.right + (i & 2 ? low : high)[1] * axes.up +
                      (i & 4 ? low : high)[2] * axes.towards);
  for (PictureScene& scene : scenes) {
    scene.in_view = corners;
    if (scene.contours > 0) scene.contour_range = range;
    scene.field_limit = limit;
  }
}

void draw_contact_sheet(const fs::path& path, const std::vector<PictureScene>& scenes, int columns,
                        const PictureSize& size) {
  if (scenes.empty()) throw InputError("a contact sheet needs at least one scene");
  if (columns < 1)
    throw InputError("found " + std::to_string(columns) + " columns, expected 1 or more");
  draw_scenes(path, scenes, std::min(columns, isize(scenes)), true, size);
}

namespace {

using namespace detail;

using Loop = std::vector<HermiteCurve>;

std::vector<Vec3> points_along(const Loop& loop) {
  std::vector<Vec3> points;
  for (const Vec3& p : points_of(*polylines(loop))) points.push_back(p);
  return points;
}

/// The loop as one closed polyline of points, evenly spaced by length.
std::vector<Vec3> chain(const Loop& loop, int count) {
  std::vector<Vec3> points;
  for (size_t k = 0; k < loop.size(); ++k) {
    std::vector<Vec3> more = points_along({loop[k]});
    const std::vector<Vec3> next = points_along({loop[(k + 1) % loop.size()]});
    const auto gap = [](const Vec3& p, const std::vector<Vec3>& ends) {
      return std::min((p - ends.front()).norm(), (p - ends.back()).norm());
    };
    const bool turned =
        k == 0 ? loop.size() > 1 && gap(more.front(), next) < gap(more.back(), next)
               : (more.back() - points.back()).norm() < (more.front() - points.back()).norm();
    if (turned) std::reverse(more.begin(), more.end());
    points.insert(points.end(), more.begin(), more.end());
  }
  std::vector<double> at(1, 0.0);
  for (size_t i = 1; i < points.size(); ++i)
    at.push_back(at.back() + (points[i] - points[i - 1]).norm());
  std::vector<Vec3> even;
  size_t i = 1;
  for (int k = 0; k < count; ++k) {
    const double s = at.back() * k / count;
    while (i + 1 < points.size() && at[i] < s) ++i;
    const double length = at[i] - at[i - 1];
    even.push_back(points[i - 1] +
                   (length > 0 ? (s - at[i - 1]) / length : 0) * (points[i] - points[i - 1]));
  }
  return even;
}

/// Triangles as VTK data.
class Sheet {
 public:
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const vtkIdType corners[3] = {add(a), add(b), add(c)};
    triangles_->InsertNextCell(3, corners);
  }
  vtkSmartPointer<vtkPolyData> data() const {
    auto result = vtkSmartPointer<vtkPolyData>::New();
    result->SetPoints(points_);
    result->SetPolys(triangles_);
    return result;
  }

 private:
  vtkIdType add(const Vec3& p) { return points_->InsertNextPoint(p.data()); }
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> triangles_;
};

constexpr int kAround = 240;  // points per loop

/// A triangle fan from the centre of the loop to its curves.
vtkSmartPointer<vtkPolyData> fan(const Loop& loop) {
  const std::vector<Vec3> rim = chain(loop, kAround);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : rim) middle += p / kAround;
  Sheet sheet;
  for (size_t i = 0; i < rim.size(); ++i) sheet.triangle(middle, rim[i], rim[(i + 1) % kAround]);
  return sheet.data();
}

/// A band between two loops, rotated and oriented so that it is as short as possible.
vtkSmartPointer<vtkPolyData> band(const Loop& one, const Loop& other) {
  const std::vector<Vec3> a = chain(one, kAround);
  std::vector<Vec3> b = chain(other, kAround), best;
  double least = std::numeric_limits<double>::infinity();
  for (int way = 0; way < 2; ++way) {
    for (int shift = 0; shift < kAround; shift += 4) {
      std::vector<Vec3> turned = b;
      std::rotate(turned.begin(), turned.begin() + shift, turned.end());
      double sum = 0;
      for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - turned[i]).squaredNorm();
      if (sum >= least) continue;
      least = sum;
      best = turned;
    }
    std::reverse(b.begin(), b.end());
  }
  Sheet sheet;
  for (size_t i = 0; i < a.size(); ++i) {
    const size_t next = (i + 1) % kAround;
    sheet.triangle(a[i], a[next], best[i]);
    sheet.triangle(a[next], best[next], best[i]);
  }
  return sheet.data();
}

std::vector<vtkSmartPointer<vtkPolyData>> sheets(const LoopAlternative& panel) {
  std::vector<vtkSmartPointer<vtkPolyData>> all;
  if (panel.one_surface && panel.loops.size() == 2) return {band(panel.loops[0], panel.loops[1])};
  for (const Loop& loop : panel.loops) all.push_back(fan(loop));
  return all;
}

Colour sheet_colour(int index) {
  constexpr double golden = 0.6180339887498949;
  Colour rgb;
  vtkMath::HSVToRGB(std::fmod(0.58 + index * golden, 1.0), 0.5, 0.9, &rgb[0], &rgb[1], &rgb[2]);
  return rgb;
}

/// The points of the loops, and the corners of their bounding box scaled by 1.5.
std::vector<Vec3> near(const std::vector<Vec3>& loops) {
  const Box3 box = bounding_box(loops);
  std::vector<Vec3> seen = loops;
  for (const Vec3& p : {box.min(), box.max()})
    seen.push_back(box.center() + 1.5 * (p - box.center()));
  return seen;
}

/// The view perpendicular to nearly flat loops; the direction `afar` for others.
ViewAxes near_axes(const std::vector<Vec3>& loops, const ViewAxes& afar) {
  constexpr double flat = 0.05;  // ratio of squared extents
  const Vec3 sizes = principal_axes(loops).values;
  return sizes[0] <= flat * sizes[2] ? best_view(loops) : afar;
}

void draw(vtkRenderer& renderer, const LoopPicture& picture, const LoopAlternative& panel,
          const ViewAxes& axes, const std::vector<Vec3>& visible_points, double width,
          double height) {
  set_stage(renderer);
  const Viewport viewport = viewport_of(width, height, panel.title, true, 0);
  const Fit view = fit(visible_points, axes, viewport, 1);
  const Vec3 offset = 4 * view.pixel * axes.towards;
  int index = 0;
  for (const auto& data : sheets(panel)) {
    const auto sheet = actor(nullptr, data, sheet_colour(index++));
    sheet->GetProperty()->LightingOff();
    sheet->GetProperty()->SetOpacity(0.55);
    renderer.AddActor(sheet);
  }
  for (const Loop& loop : panel.loops)
    add_tubes(renderer, polylines(loop), kLine, 2.6 * viewport.unit * view.pixel, offset);
  add_thin_lines(renderer, polylines(picture.lines), kMesh, 1.6 * viewport.unit, Vec3::Zero());
  add_title(renderer, panel.title, width, height, true);
  set_camera(renderer, axes, view, width, height);
}

}  // namespace

void draw_loops(const std::filesystem::path& path, const LoopPicture& picture) {
  if (picture.alternatives.empty())
    throw InputError(path.string() + ": found no alternatives to draw, expected at least one");
  LoopAlternative everywhere{"location", {}, picture.alternatives.front().one_surface};
  std::vector<Vec3> all, of_loops;
  for (const HermiteCurve& line : picture.lines)
    for (const Vec3& p : points_along({line})) all.push_back(p);
  for (const LoopAlternative& way : picture.alternatives)
    for (const Loop& loop : way.loops) {
      everywhere.loops.push_back(loop);
      for (const Vec3& p : points_along(loop)) of_loops.push_back(p);
    }
  if (of_loops.empty())
    throw InputError(path.string() +
                     ": found alternatives without loops of curves, expected at least one loop");
  const ViewAxes afar(picture.azimuth, picture.elevation), close = near_axes(of_loops, afar);
  const std::vector<Vec3> nearby = near(of_loops);
  const int panels = 1 + isize(picture.alternatives), columns = std::min(panels, 3);
  const int rows = (panels + columns - 1) / columns;
  constexpr int wide = 700, high = 600;
  draw_sheet(path, panels, columns, true, {wide * columns, high * rows},
             [&](vtkRenderer& renderer, int i, double width, double height) {
               if (i == 0)
                 draw(renderer, picture, everywhere, afar, all, width, height);
               else
                 draw(renderer, picture, picture.alternatives[static_cast<size_t>(i - 1)], close,
                      nearby, width, height);
             });
}

}  // namespace batten
