#include "batten/apps/studio/view/shape_actors.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellPicker.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "batten/apps/studio/view/shape_colours.h"

namespace batten::studio {
namespace {

constexpr double kStripes = 28;  // of a zebra, over half a turn
constexpr int kBands = 24;

vtkIdType count_of_triples(const std::vector<float>& values) {
  return static_cast<vtkIdType>(values.size() / 3);
}

void copy_into(vtkFloatArray& array, const std::vector<float>& values) {
  if (array.GetNumberOfTuples() != count_of_triples(values))
    array.SetNumberOfTuples(count_of_triples(values));
  if (!values.empty())
    std::memcpy(array.GetPointer(0), values.data(), values.size() * sizeof(float));
  array.Modified();
}

}  // namespace

/// One set of cells and the actor that draws them.
struct ShapeActors::Layer {
  Layer(vtkRenderer* renderer, double order, double width) {
    mapper->SetInputData(data);
    mapper->SetResolveCoincidentTopologyToPolygonOffset();
    mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(0, order);
    mapper->SetRelativeCoincidentTopologyLineOffsetParameters(0, order);
    mapper->ScalarVisibilityOff();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetLineWidth(static_cast<float>(width));
    if (width > 0) actor->GetProperty()->LightingOff();
    renderer->AddActor(actor);
  }
  void set_colour(const std::array<double, 3>& c) {
    actor->GetProperty()->SetColor(c[0], c[1], c[2]);
  }
  void set_polylines(const std::vector<std::vector<Vec3>>& lines) {
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> cells;
    for (const auto& line : lines) {
      cells->InsertNextCell(static_cast<int>(line.size()));
      for (const Vec3& p : line) cells->InsertCellPoint(points->InsertNextPoint(p.data()));
    }
    data->SetPoints(points);
    data->SetLines(cells);
    data->Modified();
  }
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkActor> actor;
};

ShapeActors::ShapeActors(vtkRenderer* renderer)
    : facets_(std::make_unique<Layer>(renderer, 2, 0)),
      lines_(std::make_unique<Layer>(renderer, -2, 2.5)),
      chosen_(std::make_unique<Layer>(renderer, -6, 5)),
      draft_(std::make_unique<Layer>(renderer, -8, 3)),
      push_(std::make_unique<Layer>(renderer, -8, 3)),
      grid_(std::make_unique<Layer>(renderer, 4, 1)),
      points_(vtkSmartPointer<vtkFloatArray>::New()),
      normals_(vtkSmartPointer<vtkFloatArray>::New()),
      scalars_(vtkSmartPointer<vtkFloatArray>::New()),
      renderer_(renderer),
      palette_(Palette::light()) {
  points_->SetNumberOfComponents(3);
  normals_->SetNumberOfComponents(3);
  vtkNew<vtkPoints> points;
  points->SetData(points_);
  facets_->data->SetPoints(points);
  vtkProperty* property = facets_->actor->GetProperty();
  property->SetInterpolationToPhong();
  property->SetAmbient(0.2);
  property->SetDiffuse(0.82);
  property->SetSpecular(0.22);
  property->SetSpecularPower(28);
  draft_->actor->GetProperty()->SetPointSize(9);
  draft_->actor->GetProperty()->SetRenderPointsAsSpheres(true);
  colour();
}

ShapeActors::~ShapeActors() = default;

void ShapeActors::take(const DocumentView& view) {
  surface_ = view.surface;
  regions_ = view.regions;
  shown_lines_ = view.shown_lines;
  loose_ = view.lines;
  if (!surface_) {
    pattern_ = nullptr;
    facets_->data->SetPolys(nullptr);
    facets_->data->Modified();
  }
  make_lines();
  shade();
}

void ShapeActors::take(const Frame& frame) {
  copy_into(*points_, frame.points);
  copy_into(*normals_, frame.normals);
  facets_->data->GetPoints()->Modified();
  facets_->data->GetPointData()->SetNormals(normals_);
  if (frame.pattern != pattern_) {
    pattern_ = frame.pattern;
    reference_ = frame.points;
    make_facets();
    make_lines();
  }
  lines_->data->GetPoints()->Modified();
  facets_->data->Modified();
  lines_->data->Modified();
  shade();
}

void ShapeActors::make_facets() {
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkIntArray> regions;
  size_t region = 0;
  int number = 0;
  for (const auto& facet : pattern_->facets) {
    while (region + 2 < pattern_->first_facet.size() && number >= pattern_->first_facet[region + 1])
      ++region;
    const vtkIdType corners[3] = {facet[0], facet[1], facet[2]};
    cells->InsertNextCell(3, corners);
    regions->InsertNextValue(static_cast<int>(region));
    ++number;
  }
  facets_->data->SetPolys(cells);
  facets_->data->GetCellData()->SetScalars(regions);
}

// Lines on the surface move with its points; without one they are drawn as they were read.
void ShapeActors::make_lines() {
  line_names_.clear();
  const bool on_surface = pattern_ && surface_;
  if (on_surface) {
    vtkNew<vtkCellArray> cells;
    for (size_t line = 0; line < pattern_->lines.size(); ++line)
      for (const auto& piece : pattern_->lines[line]) {
        cells->InsertNextCell(static_cast<int>(piece.size()));
        for (const int p : piece) cells->InsertCellPoint(p);
        line_names_.push_back(line < shown_lines_.size() ? shown_lines_[line] : "");
      }
    lines_->data->SetPoints(facets_->data->GetPoints());
    lines_->data->SetLines(cells);
  } else {
    std::vector<std::vector<Vec3>> lines;
    for (const auto& line : loose_) {
      lines.push_back(line.points);
      line_names_.push_back(line.line);
    }
    lines_->set_polylines(lines);
  }
  lines_->data->Modified();
  choose(choice_);
}

void ShapeActors::choose(const std::string& name) {
  choice_ = name;
  vtkNew<vtkCellArray> cells;
  vtkCellArray* all = lines_->data->GetLines();
  vtkIdType count = 0;
  const vtkIdType* points = nullptr;
  for (size_t i = 0; all && i < line_names_.size(); ++i)
    if (!name.empty() && line_names_[i] == name) {
      all->GetCellAtId(static_cast<vtkIdType>(i), count, points);
      cells->InsertNextCell(count, points);
    }
  chosen_->data->SetPoints(lines_->data->GetPoints());
  chosen_->data->SetLines(cells);
  chosen_->data->Modified();
}

void ShapeActors::set_shading(Shading shading) {
  shading_ = shading;
  shade();
}

void ShapeActors::shade() {
  vtkPolyDataMapper& mapper = *facets_->mapper;
  const vtkIdType n = points_->GetNumberOfTuples();
  if (shading_ == Shading::Plain || !pattern_ || n == 0) {
    mapper.ScalarVisibilityOff();
    return;
  }
  mapper.ScalarVisibilityOn();
  if (shading_ == Shading::Regions) {
    const auto table = region_colours(static_cast<int>(regions_.size()));
    mapper.SetScalarModeToUseCellData();
    mapper.InterpolateScalarsBeforeMappingOff();
    mapper.SetLookupTable(table);
    mapper.SetScalarRange(table->GetTableRange());
    return;
  }
  scalars_->SetNumberOfComponents(1);
  scalars_->SetNumberOfTuples(n);
  float* value = scalars_->GetPointer(0);
  const float *x = points_->GetPointer(0), *normal = normals_->GetPointer(0);
  const Vec3 along = Vec3(1, 0.6, 0).normalized();
  float low = std::numeric_limits<float>::max(), high = -low;
  for (vtkIdType i = 0; i < n; ++i, x += 3, normal += 3) {
    if (shading_ == Shading::Zebra) {
      const double c = normal[0] * along.x() + normal[1] * along.y() + normal[2] * along.z();
      value[i] = static_cast<float>(std::acos(std::clamp(c, -1.0, 1.0)) * 180 / std::numbers::pi);
    } else if (shading_ == Shading::Contours) {
      value[i] = x[2];
    } else {
      const float* r = reference_.data() + 3 * i;
      value[i] = std::hypot(x[0] - r[0], x[1] - r[1], x[2] - r[2]);
    }
    low = std::min(low, value[i]);
    high = std::max(high, value[i]);
  }
  scalars_->Modified();
  facets_->data->GetPointData()->SetScalars(scalars_);
  const std::array<double, 3> light{0.97, 0.97, 0.97}, ink{0.13, 0.15, 0.19};
  vtkSmartPointer<vtkLookupTable> table;
  if (shading_ == Shading::Zebra)
    table = stripes(0, 180, static_cast<int>(2 * kStripes), light, ink);
  else if (shading_ == Shading::Contours)
    table = stripes(low, high > low ? high : low + 1, kBands, palette_.body, light);
  else
    table = distances(std::max(high, 1e-30f));
  mapper.SetScalarModeToUsePointData();
  mapper.InterpolateScalarsBeforeMappingOn();
  mapper.SetLookupTable(table);
  mapper.SetScalarRange(table->GetTableRange());
}

void ShapeActors::set_palette(const Palette& palette) {
  palette_ = palette;
  colour();
  shade();
}

void ShapeActors::colour() {
  renderer_->GradientBackgroundOn();
  renderer_->SetBackground(palette_.low.data());
  renderer_->SetBackground2(palette_.high.data());
  facets_->set_colour(palette_.body);
  facets_->actor->GetProperty()->SetEdgeColor(palette_.line.data());
  lines_->set_colour(palette_.line);
  chosen_->set_colour(palette_.chosen);
  draft_->set_colour(palette_.draft);
  push_->set_colour(palette_.chosen);
  std::array<double, 3> grid{};
  for (size_t i = 0; i < 3; ++i) grid[i] = 0.8 * palette_.low[i] + 0.2 * palette_.line[i];
  grid_->set_colour(grid);
}

void ShapeActors::set_mesh(bool shown) { facets_->actor->GetProperty()->SetEdgeVisibility(shown); }

void ShapeActors::set_draft(const std::vector<Vec3>& points) {
  draft_->set_polylines(points.size() > 1 ? std::vector<std::vector<Vec3>>{points}
                                          : std::vector<std::vector<Vec3>>{});
  vtkNew<vtkPoints> dots;
  vtkNew<vtkCellArray> vertices;
  for (const Vec3& p : points) {
    const vtkIdType id = dots->InsertNextPoint(p.data());
    vertices->InsertNextCell(1, &id);
  }
  draft_->data->SetPoints(dots);
  draft_->data->SetVerts(vertices);
  draft_->data->Modified();
}

void ShapeActors::set_grid(const std::optional<std::pair<Vec3, Vec3>>& axes) {
  std::vector<std::vector<Vec3>> lines;
  if (axes) {
    const auto [low, high] = box();
    const double reach = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    constexpr int cells = 10;  // from the origin on
    const double step = std::pow(10, std::ceil(std::log10(reach / cells)));
    for (int i = -cells; i <= cells; ++i)
      for (const auto& [a, b] : {*axes, std::pair(axes->second, axes->first)})
        lines.push_back({step * (i * a - cells * b), step * (i * a + cells * b)});
  }
  grid_->set_polylines(lines);
}

void ShapeActors::set_push(const std::optional<std::pair<Vec3, Vec3>>& from_to) {
  std::vector<std::vector<Vec3>> lines;
  if (from_to) {
    const auto& [from, to] = *from_to;
    const Vec3 along = to - from, side = 0.18 * along.unitOrthogonal() * along.norm();
    lines = {{from, to}, {to, to - 0.3 * along + side}, {to, to - 0.3 * along - side}};
  }
  push_->set_polylines(lines);
}

std::optional<Vec3> ShapeActors::surface_at(double x, double y) const {
  if (!pattern_) return std::nullopt;
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0);
  picker->PickFromListOn();
  picker->AddPickList(facets_->actor);
  if (!picker->Pick(x, y, 0, renderer_)) return std::nullopt;
  Vec3 p;
  picker->GetPickPosition(p.data());
  return p;
}

std::string ShapeActors::line_at(double x, double y) const {
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0.006);
  picker->PickFromListOn();
  picker->AddPickList(lines_->actor);
  if (pattern_) picker->AddPickList(facets_->actor);  // what lies in front hides lines
  if (!picker->Pick(x, y, 0, renderer_) || picker->GetActor() != lines_->actor.Get()) return "";
  const vtkIdType cell = picker->GetCellId();
  const auto count = static_cast<vtkIdType>(line_names_.size());
  return cell >= 0 && cell < count ? line_names_[static_cast<size_t>(cell)] : "";
}

std::string ShapeActors::region_at(double x, double y) const {
  if (!pattern_) return "";
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0);
  picker->PickFromListOn();
  picker->AddPickList(facets_->actor);
  if (!picker->Pick(x, y, 0, renderer_)) return "";
  const auto& first = pattern_->first_facet;
  const auto behind = std::upper_bound(first.begin(), first.end(), picker->GetCellId());
  const auto region = static_cast<size_t>(behind - first.begin());
  return region > 0 && region <= regions_.size() ? regions_[region - 1] : "";
}

int ShapeActors::point_near(const Vec3& p) const {
  int best = -1;
  double least = std::numeric_limits<double>::max();
  for (vtkIdType i = 0; i < points_->GetNumberOfTuples(); ++i) {
    const double d = (point(static_cast<int>(i)) - p).squaredNorm();
    if (d < least) {
      least = d;
      best = static_cast<int>(i);
    }
  }
  return best;
}

Vec3 ShapeActors::point(int number) const {
  const float* x = points_->GetPointer(3 * static_cast<vtkIdType>(number));
  return {x[0], x[1], x[2]};
}

std::array<Vec3, 2> ShapeActors::box() const {
  std::array<Vec3, 2> box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (const auto& line : loose_)
    for (const Vec3& p : line.points) {
      box[0] = box[0].cwiseMin(p);
      box[1] = box[1].cwiseMax(p);
    }
  for (vtkIdType i = 0; pattern_ && i < points_->GetNumberOfTuples(); ++i) {
    const Vec3 p = point(static_cast<int>(i));
    box[0] = box[0].cwiseMin(p);
    box[1] = box[1].cwiseMax(p);
  }
  if (box[0].x() > box[1].x()) return {Vec3::Constant(-100), Vec3::Constant(100)};
  return box;
}

}  // namespace batten::studio
