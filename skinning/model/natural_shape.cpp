#include "batten/skinning/model/natural_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/dense.h"
#include "batten/core/parallel.h"
#include "batten/core/words.h"
#include "batten/skinning/model/section_surface.h"

namespace batten {
namespace {

constexpr double kNear = 1e-4;     // of the region's size
constexpr double kParallel = 1.0;  // degrees

struct Plane {
  Vec3 at, normal;
  double off(const Vec3& p) const { return std::abs((p - at).dot(normal)); }
};

Plane plane_through(const std::vector<Vec3>& points) {
  const PrincipalAxes axes = principal_axes(points);
  return {axes.mean, axes.axes.col(0)};
}

std::vector<Vec3> points_of(const HermiteCurve& curve) {
  constexpr int samples = 4;  // of a segment
  std::vector<Vec3> points;
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k < samples; ++k)
      points.push_back(curve.evaluate(CurveMesh::Where{s, k / double(samples)}));
  points.push_back(curve.evaluate(curve.end()));
  return points;
}

// Of all lines.
Plane plane_of(const RegionLayout& region, double& farthest) {
  std::vector<Vec3> points;
  const auto add = [&](const HermiteCurve& curve) {
    const std::vector<Vec3> more = points_of(curve);
    points.insert(points.end(), more.begin(), more.end());
  };
  for (const LineRun& run : region.runs()) add(run.fitted);
  for (const EmbeddedLine& line : region.embedded()) add(line.fitted);
  const Plane plane = plane_through(points);
  farthest = 0;
  for (const Vec3& p : points) farthest = std::max(farthest, plane.off(p));
  return plane;
}

// Whether both sides beside `side` are straight.
bool has_rails(const RegionLayout& region, int side) {
  for (int k = 1; k < 4; k += 2) {
    std::vector<Vec3> points;
    for (const LineRun& run : region.runs()) {
      if (run.line.role != CharacterLine::Role::Outline ||
          domain_side(region, run) != (side + k) % 4)
        continue;
      const std::vector<Vec3> more = points_of(run.fitted);
      points.insert(points.end(), more.begin(), more.end());
    }
    if (points.empty()) return false;
    size_t far = 0;
    for (size_t i = 0; i < points.size(); ++i)
      if ((points[i] - points[0]).norm() > (points[far] - points[0]).norm()) far = i;
    const Vec3 along = (points[far] - points[0]).normalized();
    for (const Vec3& p : points)
      if (along.cross(p - points[0]).norm() > kNear * region.size()) return false;
  }
  return true;
}

struct Circle {
  Vec3 centre, axis;
  double radius;
};

// The circle that a section is a part of: where it is equally far from the axis in its middle.
std::optional<Circle> circle_of(const SectionSurface& surface, bool last, double tolerance) {
  constexpr int samples = 24;
  std::vector<Vec3> points;
  for (int k = 0; k < samples; ++k) points.push_back(surface.on_section((k + 0.5) / samples, last));
  const Vec3 &a = points[0], b = points[samples / 3] - a, c = points[2 * samples / 3] - a;
  const Vec3 axis = b.cross(c);
  if (!(axis.norm() > 1e-3 * b.norm() * c.norm())) return std::nullopt;
  const Vec3 to_centre = (axis.cross(b) * c.squaredNorm() + c.cross(axis) * b.squaredNorm()) /
                         (2 * axis.squaredNorm());
  Circle circle{a + to_centre, axis.normalized(), 0};
  for (const Vec3& p : points) circle.radius += (p - circle.centre).norm() / samples;
  for (const Vec3& p : points) {
    const Vec3 d = p - circle.centre;
    if (std::abs(d.dot(circle.axis)) > tolerance || std::abs(d.norm() - circle.radius) > tolerance)
      return std::nullopt;
  }
  return circle;
}

bool is_extrusion(const SectionSurface& surface, double tolerance) {
  constexpr int samples = 16;
  const auto across = [&](double s) -> Vec3 {
    return surface.on_section(s, true) - surface.on_section(s, false);
  };
  const Vec3 first = across(0.5 / samples);
  for (int k = 1; k < samples; ++k)
    if ((across((k + 0.5) / samples) - first).norm() > tolerance) return false;
  return true;
}

// Around an axis, from sections that are arcs about it.
class Revolved {
 public:
  Revolved(const RegionLayout& region, int side)
      : arcs_(region, side), meridians_(region, side + 1), size_(region.size()) {}

  // Whether the other two sides are one meridian, turned.
  NaturalShape shape(int side) {
    constexpr double near = 5 * kNear;
    const double tolerance = near * size_;
    const auto one = circle_of(arcs_, false, tolerance), two = circle_of(arcs_, true, tolerance);
    if (!one || !two) return {};
    // The larger circle knows the axis better.
    const Circle& known = one->radius > two->radius ? *one : *two;
    centre_ = known.centre;
    axis_ = known.axis;
    for (const auto* circle : {&*one, &*two}) {
      const Vec3 d = circle->centre - centre_;
      if ((d - d.dot(axis_) * axis_).norm() > tolerance) return {};
      if (axis_.cross(circle->axis).norm() * circle->radius > tolerance) return {};
    }
    constexpr int samples = 16;
    for (int k = 0; k <= samples; ++k) {
      const double t = k / double(samples);
      if ((turned(meridians_.on_section(t, false), angle(1)) - meridians_.on_section(t, true))
              .norm() > tolerance)
        return {};
      if ((turned(arcs_.on_section(0, true), angle(t)) - arcs_.on_section(t, true)).norm() >
          tolerance)
        return {};
    }
    using Kind = NaturalShape::Kind;
    const auto meridian = circle_of(meridians_, false, tolerance);
    if (!meridian || std::abs(meridian->axis.dot(axis_)) > near) return {Kind::Revolution, 0, side};
    const Vec3 d = meridian->centre - centre_;
    const bool on_axis = (d - d.dot(axis_) * axis_).norm() <= tolerance;
    return {on_axis ? Kind::Sphere : Kind::Torus, meridian->radius, side};
  }

  // After shape().
  Points dofs() const {
    return arcs_.dofs_of([this](const Vec2& st) {
      constexpr double h = 1e-5;
      const double a = std::clamp(st[0], h, 1 - h), b = std::clamp(st[1], h, 1 - h);
      const double turn = angle(st[0]), speed = (angle(a + h) - angle(a - h)) / (2 * h);
      const Vec3 along =
          (meridians_.on_section(b + h, false) - meridians_.on_section(b - h, false)) / (2 * h);
      SectionSurface::Slopes slopes;
      slopes.x = turned(meridians_.on_section(st[1], false), turn);
      slopes.by_s = speed * axis_.cross(slopes.x - centre_);
      slopes.by_t = Eigen::AngleAxisd(turn, axis_) * along;
      return slopes;
    });
  }

 private:
  // Of the first arc, from its start on; less than a turn.
  double angle(double s) const {
    const auto from = [&](double at) -> Vec3 {
      const Vec3 d = arcs_.on_section(at, false) - centre_;
      return d - d.dot(axis_) * axis_;
    };
    const Vec3 start = from(0), middle = from(0.5 * s), end = from(s);
    const auto between = [&](const Vec3& p, const Vec3& q) {
      return std::atan2(p.cross(q).dot(axis_), p.dot(q));
    };
    return between(start, middle) + between(middle, end);
  }
  Vec3 turned(const Vec3& x, double angle) const {
    return centre_ + Eigen::AngleAxisd(angle, axis_) * (x - centre_);
  }

  SectionSurface arcs_, meridians_;
  double size_;
  Vec3 centre_ = Vec3::Zero(), axis_ = Vec3::UnitZ();
};

Points rest_dofs(const RegionLayout& region, const NaturalShape& shape) {
  using Kind = NaturalShape::Kind;
  if (shape.kind != Kind::Sphere && shape.kind != Kind::Torus && shape.kind != Kind::Revolution)
    return SectionSurface(region, shape.side).dofs();
  Revolved revolved(region, shape.side);
  revolved.shape(shape.side);
  return revolved.dofs();
}

NaturalShape ruled(const RegionLayout& region, int side) {
  const SectionSurface surface(region, side);
  NaturalShape shape;
  shape.side = side;
  if (surface.twist_deg() > kParallel) return {};
  using Kind = NaturalShape::Kind;
  const double tolerance = 5 * kNear * region.size();
  shape.kind = is_extrusion(surface, tolerance) ? Kind::Extrusion : Kind::Developable;
  const auto one = circle_of(surface, false, tolerance), two = circle_of(surface, true, tolerance);
  if (!one || !two) return shape;
  const Vec3 apart = two->centre - one->centre;
  const auto across = [&](const Vec3& axis) {
    return degrees_between(axis, apart.dot(axis) < 0 ? Vec3(-apart) : apart);
  };
  if (across(one->axis) > kParallel || across(two->axis) > kParallel) return shape;
  shape.kind = shape.kind == Kind::Extrusion ? Kind::Cylinder : Kind::Cone;
  shape.radius = std::max(one->radius, two->radius);
  return shape;
}

}  // namespace

NaturalShape natural_shape(const RegionLayout& region) {
  double farthest = 0;
  plane_of(region, farthest);
  if (farthest <= kNear * region.size()) return {NaturalShape::Kind::Plane};
  const bool inner =
      std::any_of(region.embedded().begin(), region.embedded().end(),
                  [](const auto& e) { return e.line.role != CharacterLine::Role::Hole; }) ||
      std::any_of(region.runs().begin(), region.runs().end(),
                  [](const auto& run) { return run.line.role != CharacterLine::Role::Outline; });
  if (inner) return {};
  if (is_ring(region)) return ruled(region, 0);
  if (region.corners().size() != 4) return {};
  for (const int side : {0, 1})
    if (has_rails(region, side))
      if (const NaturalShape shape = ruled(region, side); shape.has_rest()) return shape;
  for (const int side : {0, 1})
    if (const NaturalShape shape = Revolved(region, side).shape(side); shape.has_rest())
      return shape;
  return {};
}

const char* word_for(NaturalShape::Kind kind) {
  static constexpr const char* words[] = {"",       "plane",     "cylinder",
                                          "cone",   "extrusion", "unfoldable strip",
                                          "sphere", "torus",     "revolved strip"};
  return words[static_cast<size_t>(kind)];
}

Points natural_dofs(const ModelLayout& layout) {
  if (!layout.has_rest()) return {};
  std::vector<Points> rests(static_cast<size_t>(layout.region_count()));
  parallel_parts(layout.region_count(), [&](int r) {
    const NaturalShape shape = natural_shape(layout.region(r));
    if (shape.has_rest()) rests[r] = rest_dofs(layout.region(r), shape);
  });
  Points all;
  for (int r = 0; r < layout.region_count(); ++r) {
    if (rests[r].rows() == 0) continue;
    if (all.rows() == 0) all = Points::Zero(layout.position_dofs().size(), 3);
    for (int d = 0; d < rests[r].rows(); ++d) all.row(layout.numbers(r)(d)) = rests[r].row(d);
  }
  return all;
}

double off_natural(const RegionLayout& region, const NaturalShape& shape, const Points& dofs) {
  double most = 0, unused = 0;
  if (shape.kind == NaturalShape::Kind::Free) return most;
  const ParametricMesh& mesh = *region.mesh();
  const DofMap map(mesh);
  const bool plane = shape.kind == NaturalShape::Kind::Plane;
  const Plane flat = plane ? plane_of(region, unused) : Plane{};
  const Points rest = plane ? Points() : rest_dofs(region, shape);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Vec3 x = dofs.row(map.vertex(v));
    most = std::max(most, plane ? flat.off(x) : (x - rest.row(map.vertex(v)).transpose()).norm());
  }
  return most;
}

}  // namespace batten
