// Inner lines as straight runs across a polygon.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/crossing.h"
#include "batten/skinning/domains/polygon_plan.h"

namespace batten {
namespace {

bool segments_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  constexpr double margin = 1e-9;
  const double det = cross(b - a, d - c);
  if (std::abs(det) < 1e-14) return false;
  const double s = cross(c - a, d - c) / det, t = cross(c - a, b - a) / det;
  return s > margin && s < 1 - margin && t > margin && t < 1 - margin;
}

// Where an inner line's end meets the outline: a node of a piece, new unless one is near.
struct Junction {
  size_t strip;
  double fraction;
  Vec2 uv;
  Vec3 position;
};

std::optional<Junction> on_vertex(const PolygonPlan& plan, size_t piece, double fraction,
                                  const Vec3& p, std::string& reason) {
  const Strip& strip = plan.strips[piece];
  const HermiteCurve& curve = strip.line.given->curve;
  for (const double u : strip.line.given->vertices) {
    const double along = (u - curve.start()) / (curve.end() - curve.start());
    const double there = strip.flipped ? 1 - along : along;
    const Vec3 position = curve.evaluate(u);
    if ((position - p).norm() <= plan.task.join)
      return Junction{piece, there, strip.at(there), position};
  }
  reason = "it ends between two vertices of line '" + strip.line.name + "', at " +
           number(fraction) + " of it";
  return std::nullopt;
}

std::optional<Junction> junction(const PolygonPlan& plan, int end, const Vec3& p,
                                 std::string& reason) {
  double nearest = std::numeric_limits<double>::infinity(), fraction = 0;
  size_t found = 0;
  for (size_t i = 0; i < plan.outline.pieces.size(); ++i) {
    const auto closest = plan.strips[i].fitted.closest_point(p);
    if (closest.distance < nearest) {
      nearest = closest.distance;
      found = i;
      fraction = plan.strips[i].fraction(closest.u);
    }
  }
  const Strip& strip = plan.strips[found];
  if (nearest > plan.task.join) {
    reason = std::string("its ") + (end ? "end " : "start ") + at(p) + " is " + number(nearest) +
             " away from line '" + strip.line.name + "' (ends meet within " +
             number(plan.task.join) + ")";
    return std::nullopt;
  }
  if (strip.given()) return on_vertex(plan, found, fraction, p, reason);
  const double snap = std::min(plan.task.join, 0.05 * plan.task.edge) / strip.fitted.end();
  fraction = rounded(fraction);
  for (const double u : strip.fitted.parameters())
    if (std::abs(u / strip.fitted.end() - fraction) < snap) fraction = u / strip.fitted.end();
  // The same number that the outline's own node gets.
  return Junction{found, fraction, strip.at(rounded(fraction)),
                  strip.fitted.evaluate(rounded(fraction) * strip.fitted.end())};
}

std::string why_not_inside(const PolygonPlan& plan, const Stretch& s, const Strip& strip) {
  const InputCurve& curve = *s.curve;
  const std::vector<Vec3> ends = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  const BoxedCurve boxed(curve);
  if (boxed.self_crossing(1e-7 * plan.task.size).found) return "it crosses itself";
  for (const Stretch& other : plan.fitted_inner)
    if (const auto c = boxed.crossing(BoxedCurve(*other.curve), 1e-7 * plan.task.size, ends,
                                      0.02 * plan.task.size);
        c.found)
      return "it crosses line '" + other.name + "' near " + at(c.where);
  for (const Strip& other : plan.strips)
    if (segments_cross(strip.from, strip.to, other.from, other.to))
      return "it would cross line '" + other.line.name + "' in the flat domain";
  const Vec2 middle = 0.5 * (strip.from + strip.to);
  bool inside = false;
  for (size_t i = 0, n = plan.polygon.size(); i < n; ++i) {
    const Vec2 &a = plan.polygon[i], &b = plan.polygon[(i + 1) % n];
    if ((a.y() > middle.y()) != (b.y() > middle.y()) &&
        middle.x() < a.x() + (middle.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  if (!inside) return "it would run along or outside the outline of the flat domain";
  return "";
}

}  // namespace

std::string add_inner_strip(PolygonPlan& plan, const Stretch& s) {
  const InputCurve& curve = *s.curve;
  const Vec3 ends[2] = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  if ((ends[0] - ends[1]).norm() <= plan.task.join) return "it is closed";
  Strip strip;
  strip.line = s.line(false);
  Vec3 on_outline[2];
  std::array<std::optional<Junction>, 2> junctions;
  for (int e = 0; e < 2; ++e) {
    std::string reason;
    junctions[e] = junction(plan, e, ends[e], reason);
    if (!junctions[e]) return reason;
    const Junction& j = *junctions[e];
    const size_t n = plan.outline.pieces.size();
    if ((j.fraction <= 0 && plan.outline.is_corner(j.strip)) ||
        (j.fraction >= 1 && plan.outline.is_corner((j.strip + 1) % n)))
      return "it ends at a corner, where the two sides fix the surface's slopes already";
    (e ? strip.to : strip.from) = junctions[e]->uv;
    on_outline[e] = junctions[e]->position;
  }
  if (const std::string reason = why_not_inside(plan, s, strip); !reason.empty()) return reason;
  const Vec3 t0 = curve.evaluate(curve.start(), 1).normalized(),
             t1 = curve.evaluate(curve.end(), 1).normalized();
  strip.fitted =
      s.given ? s.given->curve
              : fitted_strip(plan, s, {on_outline[0], t0, t0}, {on_outline[1], t1, t1}, true);
  for (const auto& j : junctions) plan.strips[j->strip].nodes.push_back(j->fraction);
  plan.fitted_inner.push_back(s);
  plan.strips.push_back(std::move(strip));
  return "";
}

}  // namespace batten
