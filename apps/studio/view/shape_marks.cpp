// What is drawn beside the surface: points, combs, arrows, where loads act.
#include <vtkFloatArray.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/apps/studio/view/layer.h"
#include "batten/apps/studio/view/shape_actors.h"

namespace batten::studio {
namespace {

constexpr double kDot = 9;  // pixels

/// An arrow as three lines.
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
  // Against the curvature, so that the comb stands outside; a straight line has none.
  const double scale = largest * length > 1e-6 ? 0.15 * length / largest : 0;
  std::vector<Vec3> edge;
  for (size_t i = 1; scale > 0 && i + 1 < curve.size(); ++i) {
    edge.push_back(curve[i] - scale * curvature[i]);
    lines.push_back({curve[i], edge.back()});
  }
  if (!edge.empty()) lines.push_back(std::move(edge));
  comb_->set_polylines(lines);
}

void ShapeActors::set_path(const std::vector<Vec3>& way) {
  comb_->set_polylines(way.size() > 1 ? std::vector<std::vector<Vec3>>{way}
                                      : std::vector<std::vector<Vec3>>{});
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

// What acts and holds by the display points where it does, which are others with another mesh.
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

// Arrows end where loads and forces act; normals that are held stand on the surface.
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

// Lines that hold the shell, drawn wide.
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

}  // namespace batten::studio
