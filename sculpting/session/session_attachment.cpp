// SPDX-License-Identifier: MPL-2.0
#include <algorithm>
#include <cmath>

#include "batten/core/cancellation.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/session/session_system.h"
#include "batten/skinning/model/model_projector.h"

namespace batten::detail {

namespace {

void require_finite(const std::string& name, bool finite) {
  if (!finite) throw InputError("'" + name + "': a value is not finite");
}

void require_direction(const std::string& name, const Vec3& direction) {
  require_finite(name, direction.allFinite());
  if (!(direction.norm() > 0)) throw InputError("'" + name + "': the direction has length 0");
}

// Throws unless the normal is perpendicular to the line, as for any surface through it.
void require_normal_to_line(const std::string& name, const Vec3& normal, const std::string& line,
                            const HermiteCurve& curve) {
  require_direction(name, normal);
  constexpr int samples = 64;
  constexpr double most = 1;  // largest deviation from the right angle, degrees
  double worst = 0;
  Vec3 where = Vec3::Zero();
  for (int k = 0; k <= samples; ++k) {
    const double t = curve.start() + (curve.end() - curve.start()) * k / samples;
    const double off = std::abs(90 - degrees_between(curve.evaluate(t, 1), normal));
    if (off <= worst) continue;
    worst = off;
    where = curve.evaluate(t);
  }
  if (worst > most)
    throw InputError("'" + name + "' prescribes a normal that is not perpendicular to curve '" +
                     line + "': it deviates by " + format_number(worst) + " degrees near " +
                     format_point(where) +
                     "; use a normal that is perpendicular to the whole curve, or none to keep "
                     "the current tangent planes");
}

// Closest location of the surface to a point in space.
ModelPoint foot_point(const std::string& name, const Vec3& at, const ModelProjector& projector,
                      double size) {
  require_finite(name, at.allFinite());
  const auto closest = projector.nearest_inside(at);
  constexpr double far = 0.5;  // fraction of the size; a larger distance is no rounding but an
                               // input error
  if (!(closest.distance <= far * size))
    throw InputError("'" + name + "': its point is " + format_number(closest.distance) +
                     " away from the surface, expected at most half of the model size " +
                     format_number(size));
  return closest.at;
}

struct PointOnCurve {
  const ModelLine* line = nullptr;
  ModelPoint at;
  double distance = 0;  // model units
};

// The nearest point of a curve within a distance (model units) from a location; no line: none.
PointOnCurve nearest_on_curve(const ModelPoint& from, double within, const ModelLayout& layout) {
  const RegionLayout& region = layout.region(from.region);
  const double period = region.mesh()->period();
  PointOnCurve found{nullptr, from, within};
  for (const ModelLine& line : layout.lines())
    for (const LineSide& side : line.sides) {
      if (side.region != from.region) continue;
      const HermiteCurve pcurve = layout.pcurve(side);
      for (const int turn : {0, -1, 1}) {
        if (turn != 0 && period == 0) continue;
        const auto closest =
            pcurve.closest_point(Vec3(from.uv.x() + turn * period, from.uv.y(), 0));
        const double distance = closest.distance * region.size();
        if (!(distance <= found.distance)) continue;
        found.line = &line;
        found.distance = distance;
        found.at.uv = region.mesh()->wrapped(drop_z(pcurve.evaluate(closest.u)));
      }
    }
  return found;
}

SharedPoints shared(const Surface& surface) { return std::make_shared<Points>(surface.dofs()); }

void check_area(const Area& area, const SessionDefinition& def, const Surface& surface) {
  // Called only to throw InputError if the area is invalid.
  if (!everywhere(area)) triangle_weights(area, *def.layout, surface);
}

}  // namespace

HermiteCurve sum(const HermiteCurve& a, const HermiteCurve& b, double factor) {
  const HermiteCurve whole = a.with_nodes(b.parameters()), other = b.with_nodes(a.parameters());
  const CurveMesh& mesh = whole.mesh();
  Points dofs = whole.dofs();
  for (int n = 0; n < mesh.node_count(); ++n) {
    dofs.row(mesh.position_dof(n)) += factor * other.position(n).transpose();
    if (mesh.slope_in(n) != mesh.slope_out(n))
      dofs.row(mesh.slope_in(n)) += factor * other.slope_in(n).transpose();
    dofs.row(mesh.slope_out(n)) += factor * other.slope_out(n).transpose();
  }
  return {mesh, dofs};
}

AttachedLoad attach(const Load& load, const SessionDefinition& def, const Surface& surface) {
  AttachedLoad placed{load, {}, nullptr};
  const double size = def.layout->size();
  const std::string& name = load.name;
  std::optional<ModelProjector> projector;
  const auto put = [&](const Vec3& at) {
    throw_if_cancelled();
    if (!projector) projector.emplace(*def.layout, surface.dofs());
    placed.foot_points.push_back(foot_point(name, at, *projector, size));
  };
  if (const auto* p = std::get_if<Load::Pressure>(&load.kind)) {
    check_area(p->area, def, surface);
    if (!everywhere(p->area)) placed.on = shared(surface);
  } else if (const auto* u = std::get_if<Load::Uniform>(&load.kind)) {
    require_direction(name, u->direction);
    check_area(u->area, def, surface);
    if (!everywhere(u->area)) placed.on = shared(surface);
  } else if (const auto* g = std::get_if<Load::Gravity>(&load.kind)) {
    require_direction(name, g->direction);
    placed.on = shared(surface);
  } else if (const auto* f = std::get_if<Load::Point>(&load.kind)) {
    require_direction(name, f->direction);
    put(f->at);
  } else if (const auto* line = std::get_if<Load::Line>(&load.kind)) {
    require_direction(name, line->direction);
    def.layout->model_line(line->line);
  } else if (const auto* s = std::get_if<Load::AttractorSprings>(&load.kind)) {
    if (s->at.empty())
      throw InputError("'" + name + "' has no springs: 'at' is empty, expected one point or more");
    if (!(s->rest_length >= 0) || !(s->falloff >= 0) || !std::isfinite(s->rest_length + s->falloff))
      throw InputError("'" + name + "': found the rest length " + format_number(s->rest_length) +
                       " and the falloff " + format_number(s->falloff) + ", expected 0 or more");
    for (const Vec3& at : s->at) put(at);
    if (const auto* points = std::get_if<Load::AttractorSprings::TargetPoints>(&s->target)) {
      if (points->to.size() != s->at.size())
        throw InputError("'" + name + "': found " + std::to_string(s->at.size()) + " springs and " +
                         std::to_string(points->to.size()) +
                         " target points, expected equal numbers");
      for (const Vec3& to : points->to) require_finite(name, to.allFinite());
    } else if (const auto* plane = std::get_if<Load::AttractorSprings::Plane>(&s->target)) {
      require_finite(name, plane->through.allFinite());
      require_direction(name, plane->normal);
    } else if (std::get<Load::AttractorSprings::Curve>(s->target).curve.segment_count() < 1) {
      throw InputError("'" + name + "': the target curve of its springs has no segments");
    }
  } else {
    const auto& points = std::get<Load::PointCloudSprings>(load.kind).points;
    if (points.empty()) throw InputError("'" + name + "': the point cloud has no points");
    for (const Vec3& at : points) require_finite(name, at.allFinite());
  }
  return placed;
}

AttachedStiffnessField attach(const StiffnessField& weight, const SessionDefinition& def,
                              const Surface& surface) {
  check_area(weight.area, def, surface);
  if (weight.along) {
    if (const auto* uv = std::get_if<Vec2>(&*weight.along)) {
      if (!uv->allFinite() || !(uv->norm() > 0))
        throw InputError("'" + weight.name + "': the parametric direction has length 0");
    } else {
      def.layout->model_line(std::get<std::string>(*weight.along));
    }
  }
  return {weight, everywhere(weight.area) ? nullptr : shared(surface)};
}

AttachedConstraint attach(const Constraint& c, const SessionDefinition& def,
                          const Surface& surface) {
  AttachedConstraint placed{c, {}, nullptr};
  // Beside a curve, the surface could reach a goal only by a steep slope.
  constexpr double steep = 0.1, beside = 1e-3;  // slope; fraction of the size
  const auto put = [&](const Vec3& at, Vec3* goal) {
    const double size = def.layout->size(), rounding = kRoundingTolerance * size;
    const ModelProjector projector(*def.layout, surface.dofs());
    ModelPoint& foot = placed.foot_point;
    foot = foot_point(c.name, at, projector, size);
    if (def.fix_corners_only) return;
    const auto position = [&] {
      const TriangleLocator locator(*def.layout->region(foot.region).mesh());
      return projector.surface(foot.region).position(locator.locate(foot.uv));
    };
    const double moved = goal ? (position() - *goal).norm() : 0;
    const PointOnCurve near = nearest_on_curve(foot, beside * size, *def.layout);
    if (!near.line) return;
    if (near.distance <= std::max(rounding, moved / steep)) {
      if (moved > rounding) throw ConflictError({{{near.line->name, c.name}, moved}});
      foot = near.at;
    }
    if (goal && moved <= rounding) *goal = position();
  };
  if (auto* point = std::get_if<Constraint::Point>(&placed.constraint.kind)) {
    require_finite(c.name, point->goal.allFinite());
    put(point->at, &point->goal);
  } else if (const auto* normal = std::get_if<Constraint::Normal>(&c.kind)) {
    require_direction(c.name, normal->normal);
    put(normal->at, nullptr);
  } else if (const auto* tangent = std::get_if<Constraint::Tangent>(&c.kind)) {
    require_direction(c.name, tangent->tau);
    if (!tangent->along.allFinite() || !(tangent->along.norm() > 0))
      throw InputError("'" + c.name + "': the parametric direction has length 0");
    put(tangent->at, nullptr);
  } else {
    const auto& along = std::get<Constraint::LineNormal>(c.kind);
    def.layout->model_line(along.line);
    if (along.normal)
      require_normal_to_line(c.name, *along.normal, along.line, def.layout->line(along.line));
    else
      placed.on = shared(surface);
  }
  return placed;
}

namespace {

// Surface normals along a line: the mean of those on its sides.
class NormalsAlong {
 public:
  NormalsAlong(const ModelLayout& layout, const ModelLine& line, const Surface& surface)
      : surface_(surface) {
    for (const LineSide& side : line.sides)
      sides_.push_back({layout.pcurve(side), layout.against(line, side),
                        layout.first_triangle(side.region),
                        std::make_unique<TriangleLocator>(*layout.region(side.region).mesh())});
  }
  Vec3 at(double t) const {
    Vec3 sum = Vec3::Zero();
    for (const auto& side : sides_) {
      const HermiteCurve& pcurve = side.pcurve;
      Location where = side.locator->locate(
          drop_z(pcurve.evaluate(side.against ? pcurve.start() + pcurve.end() - t : t)));
      where.triangle += side.first_triangle;
      sum += surface_.jet(where).normal();
    }
    return sides_.size() == 1 ? sum : sum.normalized();
  }

 private:
  struct Side {
    HermiteCurve pcurve;
    bool against;
    int first_triangle;
    std::unique_ptr<TriangleLocator> locator;
  };
  const Surface& surface_;
  std::vector<Side> sides_;
};

void check(const LineOffset& move, const SessionDefinition& def) {
  if (def.fix_corners_only)
    throw InputError(
        "'" + move.name +
        "': curves cannot be offset, because boundary = \"corners\" fixes the corners only");
  if (move.direction) require_direction(move.name, *move.direction);
  if (!(move.fade >= 0 && move.fade <= 0.5))
    throw InputError("'" + move.name + "': found fade = " + format_number(move.fade) +
                     ", expected 0 to 0.5, the fraction of the curve's length at either end");
  const ModelLayout& layout = *def.layout;
  const ModelLine& line = layout.model_line(move.line);
  const HermiteCurve& fitted = layout.curve(line.sides.front());
  if (move.fade > 0 && fitted.closed())
    throw InputError("'" + move.name + "': found fade = " + format_number(move.fade) +
                     " for the closed curve '" + move.line + "', expected 0: it has no ends");
  if (!move.direction && line.sides.size() > 1 && !layout.join_plan(move.line))
    throw InputError("'" + move.name + "': " + std::to_string(line.sides.size()) +
                     " faces meet at the crease '" + move.line +
                     "', which has no unique normal; add a direction");
}

// Profile of an offset at a parameter of a line, and its derivative.
Vec2 profile_of(const LineOffset& move, double t, double start, double span) {
  const double s = (t - start) / span, edge = std::min(s, 1 - s);
  if (!(move.fade > 0) || edge >= move.fade) return {1, 0};
  const double r = std::clamp(edge / move.fade, 0.0, 1.0);
  return {r * r * r * (10 - 15 * r + 6 * r * r),
          (s < 0.5 ? 1 : -1) * 30 * r * r * (1 - r) * (1 - r) / (move.fade * span)};
}

// Inserts nodes where the line is long between its nodes.
HermiteCurve with_more_nodes(const LineOffset& move, const ModelLayout& layout,
                             const LineSide& first, const HermiteCurve& fitted) {
  const double start = fitted.start(), span = fitted.end() - start;
  std::vector<double> more;
  constexpr int at_least = 32;
  // On element edges the line is one cubic between vertices.
  const bool on_edges = !first.embedded;
  if (on_edges) more = layout.region(first.region).edge_aligned()[first.index].parameters;
  for (int k = 1; k < at_least && !on_edges; ++k) more.push_back(start + span * k / at_least);
  if (move.fade > 0 && !on_edges)
    for (const double f : {move.fade, 0.5 * move.fade, 1 - move.fade, 1 - 0.5 * move.fade})
      more.push_back(start + span * f);
  return fitted.with_nodes(more);
}

}  // namespace

AttachedOffset attach(const LineOffset& move, const SessionDefinition& def,
                      const Surface& surface) {
  check(move, def);
  const ModelLayout& layout = *def.layout;
  const ModelLine& line = layout.model_line(move.line);
  const HermiteCurve& fitted = layout.curve(line.sides.front());
  NormalsAlong normals(layout, line, surface);
  const double start = fitted.start(), span = fitted.end() - start;
  const auto profile = [&](double t) { return profile_of(move, t, start, span); };
  const auto direction = [&](double t) -> Vec3 {
    if (move.direction) return *move.direction;
    return normals.at(t);
  };
  const HermiteCurve nodes = with_more_nodes(move, layout, line.sides.front(), fitted);
  const CurveMesh& mesh = nodes.mesh();
  const double step = 1e-4 * span / nodes.segment_count();
  Points dofs = Points::Zero(mesh.dof_count(), 3);
  // Derivative of the direction by finite differences, one-sided where the line ends or has a
  // corner.
  const auto direction_derivative = [&](double t, int side) -> Vec3 {
    if (move.direction) return Vec3::Zero();
    if (side == 0) {
      const double before = mesh.closed() && t == start ? mesh.end() : t;
      return (direction(t + step) - direction(before - step)) / (2 * step);
    }
    const double h = side * step;
    return (-3 * direction(t) + 4 * direction(t + h) - direction(t + 2 * h)) / (2 * h);
  };
  const auto slope = [&](double t, int side) -> Vec3 {
    const Vec2 p = profile(t);
    return p[1] * direction(t) + p[0] * direction_derivative(t, side);
  };
  for (int n = 0; n < mesh.node_count(); ++n) {
    const double t = mesh.parameters()[n];
    const bool begins = n == 0 && !mesh.closed(),
               ends = n + 1 == mesh.node_count() && !mesh.closed();
    dofs.row(mesh.position_dof(n)) = profile(t)[0] * direction(t);
    if (mesh.is_corner(n)) {
      dofs.row(mesh.slope_in(n)) = slope(n == 0 ? mesh.end() : t, -1);
      dofs.row(mesh.slope_out(n)) = slope(t, 1);
    } else {
      dofs.row(mesh.slope_out(n)) = slope(t, begins ? 1 : ends ? -1 : 0);
    }
  }
  return {move, HermiteCurve(mesh, dofs)};
}

}  // namespace batten::detail
