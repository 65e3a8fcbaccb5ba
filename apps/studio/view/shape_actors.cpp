// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/studio/view/shape_actors.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellPicker.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "batten/apps/studio/view/rendering.h"

namespace batten::studio {
namespace {

/// True if a drawn line has this name or is a segment of it between nodes ("rim.2").
bool is_segment_of(const std::string& line, const std::string& name) {
  if (name.empty() || !line.starts_with(name)) return false;
  const std::string rest = line.substr(name.size());
  return rest.empty() || (rest.size() > 1 && rest[0] == '.' &&
                          rest.find_first_not_of("0123456789", 1) == rest.npos);
}

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

ShapeActors::ShapeActors(vtkRenderer* renderer)
    : facets_(std::make_unique<Layer>(renderer, 2, 0)),
      lines_(std::make_unique<Layer>(renderer, -2, 2.5)),
      guides_(std::make_unique<Layer>(renderer, -1, 1.2)),
      selection_layer_(std::make_unique<Layer>(renderer, -6, 5)),
      draft_(std::make_unique<Layer>(renderer, kInFront, 3)),
      push_(std::make_unique<Layer>(renderer, kInFront, 3)),
      grid_(std::make_unique<Layer>(renderer, 4, 1)),
      dots_(std::make_unique<Layer>(renderer, kInFront - 10, 1)),
      dot_(std::make_unique<Layer>(renderer, kInFront - 20, 1)),
      comb_(std::make_unique<Layer>(renderer, -4, 1.2)),
      marks_(std::make_unique<Layer>(renderer, kInFront + 20, 2)),
      fixed_points_layer_(std::make_unique<Layer>(renderer, kInFront + 10, 1)),
      normals_layer_(std::make_unique<Layer>(renderer, kInFront + 20, 2)),
      supports_(std::make_unique<Layer>(renderer, -4, 5)),
      points_(vtkSmartPointer<vtkFloatArray>::New()),
      normals_(vtkSmartPointer<vtkFloatArray>::New()),
      scalars_(vtkSmartPointer<vtkFloatArray>::New()),
      facet_regions_(vtkSmartPointer<vtkIntArray>::New()),
      roles_(vtkSmartPointer<vtkIntArray>::New()),
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
  colour();
}

ShapeActors::~ShapeActors() = default;

void ShapeActors::refresh(const DocumentView& view) {
  surface_ = view.surface;
  regions_ = view.regions;
  shown_lines_ = view.shown_lines;
  polylines_ = view.lines;
  mesh_ = view.mesh;
  unloaded_ = view.unloaded;
  size_ = view.size;
  take_marks(view);
  if (!surface_) {
    pattern_ = nullptr;
    facets_->data->SetPolys(nullptr);
    facets_->data->Modified();
  }
  make_lines();
}

void ShapeActors::refresh(std::shared_ptr<const StressView> stress) {
  stress_ = std::move(stress);
  place_points();
  shade();
}

// Positions of the display points: deformed by loads if stresses are shown, or by the mode shape.
void ShapeActors::place_points() {
  copy_into(*points_, frame_points_);
  if (shading_ == Shading::Stress && stress_ && stress_->moved.size() == frame_points_.size()) {
    float* x = points_->GetPointer(0);
    for (size_t i = 0; i < frame_points_.size(); ++i)
      x[i] += static_cast<float>(stress_->deformation_scale) * stress_->moved[i];
  }
  if (const auto* shape = mode_shape()) {
    constexpr double reach = 0.06;  // of the size
    float* x = points_->GetPointer(0);
    for (size_t i = 0; i < shape->size(); ++i)
      x[i] += static_cast<float>(reach * size_ * swing_) * (*shape)[i];
  }
  facets_->data->GetPoints()->Modified();
  lines_->data->Modified();
  supports_->data->Modified();
}

// The mode shape that is drawn; null if none is.
const std::vector<float>* ShapeActors::mode_shape() const {
  if (shading_ != Shading::Modes || !stress_ || stress_->mode_shapes.empty()) return nullptr;
  const size_t mode = std::min(static_cast<size_t>(mode_), stress_->mode_shapes.size() - 1);
  const auto& shape = stress_->mode_shapes[mode];
  return shape.size() == frame_points_.size() ? &shape : nullptr;
}

void ShapeActors::set_mode(int mode) {
  mode_ = mode;
  shade();
}

void ShapeActors::set_mode_phase(double swing) {
  swing_ = swing;
  place_points();
}

void ShapeActors::refresh(const Frame& frame) {
  frame_points_ = frame.points;
  place_points();
  copy_into(*normals_, frame.normals);
  facets_->data->GetPointData()->SetNormals(normals_);
  if (frame.pattern != pattern_) {
    pattern_ = frame.pattern;
    const bool as_read = mesh_ && mesh_->rest.size() == frame.points.size();
    reference_ = as_read ? mesh_->rest : frame.points;
    make_facets();
    make_lines();
    find_marks();
  } else {
    shade();
  }
  lines_->data->GetPoints()->Modified();
  facets_->data->Modified();
  lines_->data->Modified();
  supports_->data->Modified();
  if (!marked_.empty()) place_marks();
}

void ShapeActors::make_facets() {
  vtkNew<vtkCellArray> cells;
  facet_regions_->SetNumberOfTuples(0);
  size_t region = 0;
  int number = 0;
  for (const auto& facet : pattern_->facets) {
    while (region + 2 < pattern_->first_facet.size() && number >= pattern_->first_facet[region + 1])
      ++region;
    const vtkIdType corners[3] = {facet[0], facet[1], facet[2]};
    cells->InsertNextCell(3, corners);
    facet_regions_->InsertNextValue(static_cast<int>(region));
    ++number;
  }
  facets_->data->SetPolys(cells);
}

// Curves on the surface follow its points; without a surface they are drawn as they were read.
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
    for (const auto& line : polylines_) {
      lines.push_back(line.points);
      line_names_.push_back(line.line);
    }
    lines_->set_polylines(lines);
  }
  lines_->data->Modified();
  // Curves beside the surface, and the input curves of the surface's own ones.
  std::vector<std::vector<Vec3>> guides;
  for (size_t i = 0; on_surface && i < polylines_.size(); ++i)
    guides.push_back(polylines_[i].points);
  guides_->set_polylines(guides);
  show_supports();
  select(selected_name_);
}

vtkSmartPointer<vtkCellArray> ShapeActors::cells_of_lines(
    const std::function<bool(const std::string&)>& has) const {
  const auto cells = vtkSmartPointer<vtkCellArray>::New();
  vtkCellArray* all = lines_->data->GetLines();
  vtkIdType count = 0;
  const vtkIdType* points = nullptr;
  for (size_t i = 0; all && i < line_names_.size(); ++i)
    if (has(line_names_[i])) {
      all->GetCellAtId(static_cast<vtkIdType>(i), count, points);
      cells->InsertNextCell(count, points);
    }
  return cells;
}

void ShapeActors::select(const std::string& name) {
  selected_name_ = name;
  selection_layer_->data->SetPoints(lines_->data->GetPoints());
  selection_layer_->data->SetLines(
      cells_of_lines([&](const std::string& line) { return is_segment_of(line, name); }));
  selection_layer_->data->Modified();
  select_facets();
  make_roles();
  shade();
}

// Highlights the facets of a region, or of a part of a mesh.
void ShapeActors::select_facets() {
  selected_facets_.clear();
  if (!pattern_ || selected_name_.empty()) return;
  for (size_t r = 0; r < regions_.size() && r + 1 < pattern_->first_facet.size(); ++r)
    for (int f = pattern_->first_facet[r];
         regions_[r] == selected_name_ && f < pattern_->first_facet[r + 1]; ++f)
      selected_facets_.push_back(f);
  if (!mesh_is_drawn()) return;
  std::vector<char> selected(mesh_->roles.size(), 0);
  for (const MeshView::Part& part : mesh_->parts)
    if (part.name == selected_name_)
      for (const int p : part.points) selected[static_cast<size_t>(p)] = 1;
  select_within(selected);
}

void ShapeActors::select_within(const std::vector<char>& points) {
  for (size_t f = 0; f < pattern_->facets.size(); ++f) {
    const auto& facet = pattern_->facets[f];
    if (std::all_of(facet.begin(), facet.end(),
                    [&](int p) { return points[static_cast<size_t>(p)] != 0; }))
      selected_facets_.push_back(static_cast<int>(f));
  }
}

void ShapeActors::show_painted(const std::vector<char>& points) {
  selected_facets_.clear();
  if (pattern_ && points.size() == static_cast<size_t>(points_->GetNumberOfTuples()))
    select_within(points);
  make_roles();
  shade();
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
  selection_layer_->set_colour(palette_.selected);
  Rgb guide{};
  for (size_t i = 0; i < 3; ++i) guide[i] = 0.5 * (palette_.line[i] + palette_.body[i]);
  guides_->set_colour(guide);
  draft_->set_colour(palette_.draft);
  push_->set_colour(palette_.selected);
  marks_->set_colour(palette_.draft);
  fixed_points_layer_->set_colour(palette_.line);
  normals_layer_->set_colour(palette_.line);
  supports_->set_colour(palette_.line);
  dots_->set_colour(palette_.draft);
  dot_->set_colour(palette_.selected);
  comb_->set_colour(palette_.draft);
  std::array<double, 3> grid{};
  for (size_t i = 0; i < 3; ++i) grid[i] = 0.8 * palette_.low[i] + 0.2 * palette_.line[i];
  grid_->set_colour(grid);
}

void ShapeActors::set_mesh(bool shown) { facets_->actor->GetProperty()->SetEdgeVisibility(shown); }

void ShapeActors::set_clip_plane(vtkPlane* plane) {
  for (Layer* layer :
       {facets_.get(), lines_.get(), guides_.get(), selection_layer_.get(), supports_.get()}) {
    layer->mapper->RemoveAllClippingPlanes();
    if (plane) layer->mapper->AddClippingPlane(plane);
  }
}

// Overlays: points, combs, arrows, loads.

namespace {

constexpr double kDot = 9;  // pixels

/// An arrow as a polyline for the shaft and two for the tip.
std::vector<std::vector<Vec3>> arrow(const Vec3& from, const Vec3& to) {
  const Vec3 along = to - from;
  if (along.norm() == 0) return {};
  const Vec3 side = 0.18 * along.unitOrthogonal() * along.norm();
  return {{from, to}, {to, to - 0.3 * along + side}, {to, to - 0.3 * along - side}};
}

Vec3 triple_of(const std::vector<float>& values, size_t number) {
  return {values[3 * number], values[3 * number + 1], values[3 * number + 2]};
}

int nearest_point(const std::vector<float>& points, const Vec3& p) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (size_t i = 0; 3 * i < points.size(); ++i) {
    const double d = (triple_of(points, i) - p).squaredNorm();
    if (d >= least) continue;
    least = d;
    best = static_cast<int>(i);
  }
  return best;
}

}  // namespace

void ShapeActors::set_draft(const std::vector<Vec3>& points) {
  draft_->set_dots(points, true, kDot);
}

void ShapeActors::set_dots(const std::vector<Vec3>& points, int selected, bool joined) {
  dots_->set_dots(points, joined, kDot);
  const bool any = selected >= 0 && selected < static_cast<int>(points.size());
  dot_->set_dots(
      any ? std::vector<Vec3>{points[static_cast<size_t>(selected)]} : std::vector<Vec3>{}, false,
      1.4 * kDot);
}

void ShapeActors::set_comb(const std::vector<Vec3>& curve) {
  std::vector<Vec3> curvature(curve.size(), Vec3::Zero());
  double largest = 0, length = 0;
  for (size_t i = 1; i + 1 < curve.size(); ++i) {
    const Vec3 a = curve[i] - curve[i - 1], b = curve[i + 1] - curve[i];
    if (a.norm() == 0 || b.norm() == 0) continue;
    curvature[i] = 2 * (b.normalized() - a.normalized()) / (a.norm() + b.norm());
    largest = std::max(largest, curvature[i].norm());
    length += a.norm();
  }
  std::vector<std::vector<Vec3>> lines;
  // Opposite to the curvature vector, so that the comb lies outside; a straight curve has none.
  const double scale = largest * length > 1e-6 ? 0.15 * length / largest : 0;
  std::vector<Vec3> edge;
  for (size_t i = 1; scale > 0 && i + 1 < curve.size(); ++i) {
    edge.push_back(curve[i] - scale * curvature[i]);
    lines.push_back({curve[i], edge.back()});
  }
  if (!edge.empty()) lines.push_back(std::move(edge));
  comb_->set_polylines(lines);
}

void ShapeActors::set_path(const std::vector<Vec3>& path) {
  comb_->set_polylines(path.size() > 1 ? std::vector<std::vector<Vec3>>{path}
                                       : std::vector<std::vector<Vec3>>{});
}

void ShapeActors::set_grid(const std::optional<std::pair<Vec3, Vec3>>& axes) {
  std::vector<std::vector<Vec3>> lines;
  if (axes) {
    const auto [low, high] = box();
    const double reach = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    constexpr int cells = 10;  // from the origin in each direction
    const double step = std::pow(10, std::ceil(std::log10(reach / cells)));
    for (int i = -cells; i <= cells; ++i)
      for (const auto& [a, b] : {*axes, std::pair(axes->second, axes->first)})
        lines.push_back({step * (i * a - cells * b), step * (i * a + cells * b)});
  }
  grid_->set_polylines(lines);
}

void ShapeActors::set_push(const std::optional<std::pair<Vec3, Vec3>>& from_to) {
  push_->set_polylines(from_to ? arrow(from_to->first, from_to->second)
                               : std::vector<std::vector<Vec3>>{});
}

void ShapeActors::take_marks(const DocumentView& view) {
  stated_marks_ = view.marks;
  fixed_points_.clear();
  for (const auto& handle : view.handles)
    if (!handle.can_rotate) fixed_points_.push_back(handle.centre);
  supported_ = view.supported_lines;
  find_marks();
}

// Finds the display points of loads and supports, which change with the mesh.
void ShapeActors::find_marks() {
  using Kind = DocumentView::Mark::Kind;
  marked_.clear();
  for (const auto& mark : stated_marks_) {
    const bool present = mark.kind == Kind::Force || mark.kind == Kind::Support;
    const std::vector<float>* points = present ? &frame_points_ : unloaded_.get();
    const int point = points ? nearest_point(*points, mark.at) : -1;
    if (point >= 0) marked_.emplace_back(point, mark);
  }
  place_marks();
}

// Arrows end at the points of loads and forces; arrows of normal constraints start on the surface.
void ShapeActors::place_marks() {
  using Kind = DocumentView::Mark::Kind;
  const double length = 0.07 * size_;
  std::vector<std::vector<Vec3>> acting, normal_arrows;
  std::vector<Vec3> pins = fixed_points_;
  for (const auto& [number, mark] : marked_) {
    if (number >= points_->GetNumberOfTuples()) continue;
    const Vec3 at = point(number), reach = length * mark.along.stableNormalized();
    const bool acts = mark.kind == Kind::Load || mark.kind == Kind::Force;
    for (auto& line : acts ? arrow(at - reach, at) : arrow(at, at + reach))
      (acts ? acting : normal_arrows).push_back(std::move(line));
    if (!acts) pins.push_back(at);
  }
  marks_->set_polylines(acting);
  normals_layer_->set_polylines(normal_arrows);
  fixed_points_layer_->set_dots(pins, false, kDot);
}

std::vector<Vec3> ShapeActors::mark_points() const {
  std::vector<Vec3> places;
  for (const auto& [number, mark] : marked_) places.push_back(point(number));
  return places;
}

// Draws the curves that support the shell with a larger width.
void ShapeActors::show_supports() {
  const auto supports = [&](const std::string& line) {
    return std::any_of(supported_.begin(), supported_.end(),
                       [&](const std::string& name) { return is_segment_of(line, name); });
  };
  supports_->data->SetPoints(lines_->data->GetPoints());
  supports_->data->SetLines(cells_of_lines(supports));
  supports_->data->Modified();
}

std::vector<int> ShapeActors::unloaded_within(const Vec3& centre, double radius) const {
  std::vector<int> found;
  if (unloaded_)
    for (size_t i = 0; 3 * i < unloaded_->size(); ++i)
      if ((triple_of(*unloaded_, i) - centre).norm() < radius) found.push_back(static_cast<int>(i));
  return found;
}

// Shading of the surface: scalar fields and their colours.

namespace {

constexpr double kStripes = 28;  // zebra stripes over 180°
constexpr int kBands = 24;

Vec3 triple(const float* values, int number) {
  const float* v = values + 3 * static_cast<long>(number);
  return {v[0], v[1], v[2]};
}

/// Quantile of the magnitudes of values.
double quantile(std::vector<float> values, double fraction) {
  for (float& v : values) v = std::abs(v);
  const auto at =
      values.begin() + static_cast<long>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

void ShapeActors::set_shading(Shading shading) {
  shading_ = shading;
  place_points();
  shade();
}

void ShapeActors::shade() {
  const bool anything = pattern_ && points_->GetNumberOfTuples() > 0;
  if (!anything || (shading_ == Shading::Shaded && !mesh_ && selected_facets_.empty()))
    facets_->mapper->ScalarVisibilityOff();
  else if (shading_ == Shading::Shaded)
    shade_facets(roles_, role_colours(palette_));
  else if ((shading_ == Shading::Stress && !shows_stress()) ||
           (shading_ == Shading::Modes && !mode_shape()))
    facets_->mapper->ScalarVisibilityOff();
  else if (shading_ == Shading::Regions)
    shade_facets(facet_regions_, region_colours(static_cast<int>(regions_.size())));
  else
    shade_points();
}

bool ShapeActors::shows_stress() const {
  return stress_ && stress_->values.size() == static_cast<size_t>(points_->GetNumberOfTuples());
}

bool ShapeActors::has_scalar_field() const {
  return shading_ == Shading::Displacement || shading_ == Shading::Curvature ||
         shading_ == Shading::Strain || (shading_ == Shading::Stress && shows_stress()) ||
         mode_shape();
}

vtkLookupTable* ShapeActors::scale() const { return has_scalar_field() ? table_.Get() : nullptr; }

std::optional<double> ShapeActors::value_at(const Vec3& p) const {
  const int point = has_scalar_field() ? point_near(p) : -1;
  if (point < 0) return std::nullopt;
  return scalars_->GetValue(point);
}

void ShapeActors::shade_facets(vtkIntArray* values, vtkLookupTable* table) {
  vtkPolyDataMapper& mapper = *facets_->mapper;
  facets_->data->GetCellData()->SetScalars(values);
  mapper.ScalarVisibilityOn();
  mapper.SetScalarModeToUseCellData();
  mapper.InterpolateScalarsBeforeMappingOff();
  mapper.SetLookupTable(table);
  mapper.SetScalarRange(table->GetTableRange());
}

// The description of a mesh may arrive before its points.
bool ShapeActors::mesh_is_drawn() const {
  return mesh_ && mesh_->roles.size() == static_cast<size_t>(points_->GetNumberOfTuples());
}

// Colours facets whose corners all have the same role; selected facets get a colour of their own.
void ShapeActors::make_roles() {
  roles_->SetNumberOfTuples(0);
  if (!pattern_) return;
  const auto n = static_cast<vtkIdType>(pattern_->facets.size());
  roles_->SetNumberOfTuples(n);
  const bool fits = mesh_is_drawn();
  for (vtkIdType i = 0; i < n; ++i) {
    const auto& facet = pattern_->facets[static_cast<size_t>(i)];
    int role = 0;
    if (fits) {
      const auto of = [&](int corner) {
        return static_cast<int>(
            mesh_->roles[static_cast<size_t>(facet[static_cast<size_t>(corner)])]);
      };
      if (of(0) == of(1) && of(1) == of(2)) role = of(0);
    }
    roles_->SetValue(i, role);
  }
  for (const int facet : selected_facets_) roles_->SetValue(facet, kSelectedRole);
  roles_->Modified();
}

void ShapeActors::shade_points() {
  const vtkIdType n = points_->GetNumberOfTuples();
  scalars_->SetNumberOfComponents(1);
  scalars_->SetNumberOfTuples(n);
  float* value = scalars_->GetPointer(0);
  const float *x = points_->GetPointer(0), *normal = normals_->GetPointer(0);
  const Vec3 along = Vec3(1, 0.6, 0).normalized();
  if (shading_ == Shading::Curvature)
    measure_curvature(value);
  else if (shading_ == Shading::Strain)
    measure_strain(value);
  else if (shading_ == Shading::Stress)
    std::copy(stress_->values.begin(), stress_->values.end(), value);
  else if (shading_ == Shading::Modes)
    for (vtkIdType i = 0; i < n; ++i)
      value[i] = static_cast<float>(triple(mode_shape()->data(), static_cast<int>(i)).norm());
  else
    for (vtkIdType i = 0; i < n; ++i) {
      const int p = static_cast<int>(i);
      if (shading_ == Shading::Zebra)
        value[i] =
            static_cast<float>(std::acos(std::clamp(triple(normal, p).dot(along), -1.0, 1.0)) *
                               180 / std::numbers::pi);
      else if (shading_ == Shading::Contours)
        value[i] = x[3 * i + 2];
      else
        value[i] = static_cast<float>((triple(x, p) - triple(reference_.data(), p)).norm());
    }
  scalars_->Modified();
  facets_->data->GetPointData()->SetScalars(scalars_);
  table_ = table_of(value, static_cast<size_t>(n));
  vtkPolyDataMapper& mapper = *facets_->mapper;
  mapper.ScalarVisibilityOn();
  mapper.SetScalarModeToUsePointData();
  mapper.InterpolateScalarsBeforeMappingOn();
  mapper.SetLookupTable(table_);
  mapper.SetScalarRange(table_->GetTableRange());
}

vtkSmartPointer<vtkLookupTable> ShapeActors::table_of(const float* value, size_t n) {
  const auto [low, high] = std::minmax_element(value, value + n);
  const Rgb light{0.97, 0.97, 0.97}, ink{0.13, 0.15, 0.19};
  range_ = {*high, std::max(std::abs(*low), std::abs(*high))};
  switch (shading_) {
    case Shading::Zebra:
      range_ = {0, 0};
      return stripes(0, 180, static_cast<int>(2 * kStripes), light, ink);
    case Shading::Contours:
      return stripes(*low, *high > *low ? *high : *low + 1, kBands, palette_.body, light);
    case Shading::Curvature:
    case Shading::Strain: {
      // Clip the scale: values at ends and corners would leave one colour for all the rest.
      const double limit = std::max(quantile(std::vector<float>(value, value + n), 0.98), 1e-30);
      range_[0] = limit;
      return two_sided(limit);
    }
    case Shading::Stress: {
      // Clip the scale: the values at a point load would leave one colour for all the rest.
      const double limit = std::max(quantile(std::vector<float>(value, value + n), 0.995), 1e-30);
      range_ = {limit, stress_->von_mises};
      return distances(limit);
    }
    default:
      return distances(std::max<double>(*high, 1e-30));
  }
}

// Mean curvature at the display points. Per facet, the shape operator is the least-squares fit to
// the changes of the normals along its edges [Rusinkiewicz2004]. Point values are area-weighted
// means over facets. Positive if the surface is concave on the normal's side.
void ShapeActors::measure_curvature(float* value) const {
  const auto n = static_cast<size_t>(points_->GetNumberOfTuples());
  const float *x = points_->GetPointer(0), *normal = normals_->GetPointer(0);
  std::vector<double> sum(n, 0), weight(n, 0);
  for (const auto& facet : pattern_->facets) {
    const Vec3 first = triple(x, facet[1]) - triple(x, facet[0]);
    const Vec3 area = first.cross(triple(x, facet[2]) - triple(x, facet[0]));
    const double size = area.norm();
    if (!(size > 0)) continue;
    const Vec3 u = first.normalized(), v = area.cross(first).normalized();
    Mat3 A = Mat3::Zero();  // of the components uu, uv and vv of the operator
    Vec3 b = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 edge = triple(x, facet[(k + 1) % 3]) - triple(x, facet[k]);
      const Vec3 change = triple(normal, facet[(k + 1) % 3]) - triple(normal, facet[k]);
      const double eu = edge.dot(u), ev = edge.dot(v);
      const Vec3 rows[] = {{eu, ev, 0}, {0, eu, ev}};
      const double rhs[] = {change.dot(u), change.dot(v)};
      for (int i = 0; i < 2; ++i) {
        A += rows[i] * rows[i].transpose();
        b += rhs[i] * rows[i];
      }
    }
    const Vec3 shape = A.ldlt().solve(b);
    for (const int p : facet) {
      sum[static_cast<size_t>(p)] -= 0.5 * size * (shape[0] + shape[2]);
      weight[static_cast<size_t>(p)] += size;
    }
  }
  for (size_t i = 0; i < n; ++i)
    value[i] = static_cast<float>(weight[i] > 0 ? sum[i] / weight[i] : 0);
}

// Signed principal strain of largest magnitude since meshing, over the facets at each point.
void ShapeActors::measure_strain(float* value) const {
  std::fill(value, value + points_->GetNumberOfTuples(), 0.0F);
  for (const auto& facet : pattern_->facets) {
    const auto frame_of = [&](const float* points) {
      Eigen::Matrix<double, 3, 2> sides;
      sides << triple(points, facet[1]) - triple(points, facet[0]),
          triple(points, facet[2]) - triple(points, facet[0]);
      return sides;
    };
    const auto before = frame_of(reference_.data()), after = frame_of(points_->GetPointer(0));
    // The new metric in a frame that was orthonormal before (RᵀR = old metric).
    const Eigen::Matrix2d metric = before.transpose() * before;
    const Eigen::LLT<Eigen::Matrix2d> factor(metric);
    if (factor.info() != Eigen::Success) continue;
    Eigen::Matrix2d strain = after.transpose() * after;
    factor.matrixL().solveInPlace(strain);
    strain = factor.matrixL().solve(strain.transpose().eval()).eval();
    const Eigen::Vector2d squares =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(strain, Eigen::EigenvaluesOnly)
            .eigenvalues();
    const double low = std::sqrt(std::max(squares[0], 0.0)) - 1,
                 high = std::sqrt(std::max(squares[1], 0.0)) - 1;
    const auto worst = static_cast<float>(std::abs(low) > std::abs(high) ? low : high);
    for (const int p : facet)
      if (std::abs(worst) > std::abs(value[p])) value[p] = worst;
  }
}

// Picking: which objects are shown at a point of the window.

namespace {

constexpr double kNearLine = 7;   // pixels
constexpr double kBehind = 0.01;  // of the size: lines farther behind the surface are hidden

}  // namespace

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

// Name of the nearest line in the window that the surface does not hide. Lines on the surface take
// precedence over lines beside it.
std::string ShapeActors::line_at(double x, double y) const {
  const std::optional<Vec3> surface = surface_at(x, y);
  NearLine near{{x, y}, surface, kNearLine, ""};
  look_for(near, *lines_, line_names_);
  if (near.name.empty()) {
    std::vector<std::string> names;
    for (const auto& line : polylines_) names.push_back(line.line);
    look_for(near, *guides_, names);
  }
  return near.name;
}

void ShapeActors::look_for(NearLine& near, const Layer& layer,
                           const std::vector<std::string>& names) const {
  const Vec3 eye = -Vec3::Map(renderer_->GetActiveCamera()->GetDirectionOfProjection());
  const auto [low, high] = box();
  const double behind = kBehind * (high - low).norm();
  vtkCellArray* cells = layer.data->GetLines();
  vtkPoints* points = layer.data->GetPoints();
  const vtkIdType cell_count = cells && points ? cells->GetNumberOfCells() : 0;
  for (vtkIdType i = 0; i < cell_count && i < static_cast<vtkIdType>(names.size()); ++i) {
    const std::string& name = names[static_cast<size_t>(i)];
    vtkIdType count = 0;
    const vtkIdType* of = nullptr;
    cells->GetCellAtId(i, count, of);
    Vec3 before = Vec3::Zero();
    Vec2 before_at = Vec2::Zero();
    for (vtkIdType k = 0; k < count && !name.empty(); ++k) {
      const Vec3 p = Vec3::Map(points->GetPoint(of[k]));
      const Vec2 at = to_screen(*renderer_, p);
      const auto [distance, parameter] =
          distance_to_segment(near.pixel, k > 0 ? before_at : at, at);
      const Vec3 found = k > 0 ? Vec3(before + parameter * (p - before)) : p;
      if (distance < near.least && !(near.surface && (*near.surface - found).dot(eye) > behind)) {
        near.least = distance;
        near.name = name;
      }
      before = p;
      before_at = at;
    }
  }
}

int ShapeActors::facet_at(double x, double y) const {
  if (!pattern_) return -1;
  vtkNew<vtkCellPicker> picker;
  picker->SetTolerance(0);
  picker->PickFromListOn();
  picker->AddPickList(facets_->actor);
  return picker->Pick(x, y, 0, renderer_) ? static_cast<int>(picker->GetCellId()) : -1;
}

std::string ShapeActors::region_at(double x, double y) const {
  const int facet = facet_at(x, y);
  if (facet < 0) return "";
  if (mesh_) return part_of(facet);
  const auto& first = pattern_->first_facet;
  const auto behind = std::upper_bound(first.begin(), first.end(), facet);
  const auto region = static_cast<size_t>(behind - first.begin());
  return region > 0 && region <= regions_.size() ? regions_[region - 1] : "";
}

// The smallest part of the mesh that contains all corners of a facet.
std::string ShapeActors::part_of(int facet) const {
  const auto& corners = pattern_->facets[static_cast<size_t>(facet)];
  const MeshView::Part* best = nullptr;
  for (const MeshView::Part& part : mesh_->parts) {
    if (best && best->points.size() <= part.points.size()) continue;
    if (std::all_of(corners.begin(), corners.end(), [&](int p) {
          return std::find(part.points.begin(), part.points.end(), p) != part.points.end();
        }))
      best = &part;
  }
  return best ? best->name : "";
}

std::vector<int> ShapeActors::points_within(const Vec3& centre, double radius) const {
  std::vector<int> found;
  for (int i = 0; i < static_cast<int>(points_->GetNumberOfTuples()); ++i)
    if ((point(i) - centre).squaredNorm() <= radius * radius) found.push_back(i);
  return found;
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

int ShapeActors::point_count() const { return static_cast<int>(points_->GetNumberOfTuples()); }

Vec3 ShapeActors::point(int number) const {
  const float* x = points_->GetPointer(3 * static_cast<vtkIdType>(number));
  return {x[0], x[1], x[2]};
}

std::array<Vec3, 2> ShapeActors::box() const {
  std::array<Vec3, 2> box{Vec3::Constant(1e300), Vec3::Constant(-1e300)};
  for (const auto& line : polylines_)
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
