// Inner lines as straight runs across a polygon.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "batten/core/format.h"
#include "batten/core/planar_geometry.h"
#include "batten/skinning/domains/curve_crossing.h"
#include "batten/skinning/domains/polygon_domain.h"

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
  size_t aligned_segment;
  double fraction;
  Vec2 uv;
  Vec3 position;
};

std::optional<Junction> on_vertex(const PolygonDomain& domain, size_t piece, double fraction,
                                  const Vec3& p, std::string& reason) {
  const AlignedSegment& aligned_segment = domain.aligned_segments[piece];
  const HermiteCurve& curve = aligned_segment.line.prescribed->curve;
  for (const double u : aligned_segment.line.prescribed->vertices) {
    const double along = (u - curve.start()) / (curve.end() - curve.start());
    const double there = aligned_segment.flipped ? 1 - along : along;
    const Vec3 position = curve.evaluate(u);
    if ((position - p).norm() <= domain.task.gap_tolerance)
      return Junction{piece, there, aligned_segment.at(there), position};
  }
  reason = "it ends between two vertices of line '" + aligned_segment.line.name + "', at " +
           format_number(fraction) + " of it";
  return std::nullopt;
}

std::optional<Junction> junction(const PolygonDomain& domain, int end, const Vec3& p,
                                 std::string& reason) {
  double nearest = std::numeric_limits<double>::infinity(), fraction = 0;
  size_t found = 0;
  for (size_t i = 0; i < domain.outline.segments.size(); ++i) {
    const auto closest = domain.aligned_segments[i].fitted.closest_point(p);
    if (closest.distance < nearest) {
      nearest = closest.distance;
      found = i;
      fraction = domain.aligned_segments[i].fraction(closest.u);
    }
  }
  const AlignedSegment& aligned_segment = domain.aligned_segments[found];
  if (nearest > domain.task.gap_tolerance) {
    reason = std::string("its ") + (end ? "end " : "start ") + format_point(p) + " is " +
             format_number(nearest) + " away from line '" + aligned_segment.line.name +
             "' (ends meet within " + format_number(domain.task.gap_tolerance) + ")";
    return std::nullopt;
  }
  if (aligned_segment.prescribed()) return on_vertex(domain, found, fraction, p, reason);
  const double snap = std::min(domain.task.gap_tolerance, 0.05 * domain.task.edge_length) /
                      aligned_segment.fitted.end();
  fraction = round_to_grid(fraction);
  for (const double u : aligned_segment.fitted.parameters())
    if (std::abs(u / aligned_segment.fitted.end() - fraction) < snap)
      fraction = u / aligned_segment.fitted.end();
  // The same number that the outline's own node gets.
  return Junction{
      found, fraction, aligned_segment.at(round_to_grid(fraction)),
      aligned_segment.fitted.evaluate(round_to_grid(fraction) * aligned_segment.fitted.end())};
}

std::string rejection_reason(const PolygonDomain& domain, const SmoothSegment& s,
                             const AlignedSegment& aligned_segment) {
  const InputCurve& curve = *s.curve;
  const std::vector<Vec3> ends = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  const BoxedCurve boxed(curve);
  if (boxed.self_crossing(1e-7 * domain.task.size).found) return "it crosses itself";
  for (const SmoothSegment& other : domain.aligned_inner)
    if (const auto c = boxed.crossing(BoxedCurve(*other.curve), 1e-7 * domain.task.size, ends,
                                      0.02 * domain.task.size);
        c.found)
      return "it crosses line '" + other.name + "' near " + format_point(c.where);
  for (const AlignedSegment& other : domain.aligned_segments)
    if (segments_cross(aligned_segment.from, aligned_segment.to, other.from, other.to))
      return "it would cross line '" + other.line.name + "' in the flat domain";
  const Vec2 middle = 0.5 * (aligned_segment.from + aligned_segment.to);
  bool inside = false;
  for (size_t i = 0, n = domain.polygon.size(); i < n; ++i) {
    const Vec2 &a = domain.polygon[i], &b = domain.polygon[(i + 1) % n];
    if ((a.y() > middle.y()) != (b.y() > middle.y()) &&
        middle.x() < a.x() + (middle.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      inside = !inside;
  }
  if (!inside) return "it would run along or outside the outline of the flat domain";
  return "";
}

}  // namespace

std::string add_inner_segment(PolygonDomain& domain, const SmoothSegment& s) {
  const InputCurve& curve = *s.curve;
  const Vec3 ends[2] = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
  if ((ends[0] - ends[1]).norm() <= domain.task.gap_tolerance) return "it is closed";
  AlignedSegment aligned_segment;
  aligned_segment.line = s.line(false);
  Vec3 on_outline[2];
  std::array<std::optional<Junction>, 2> junctions;
  for (int e = 0; e < 2; ++e) {
    std::string reason;
    junctions[e] = junction(domain, e, ends[e], reason);
    if (!junctions[e]) return reason;
    const Junction& j = *junctions[e];
    const size_t n = domain.outline.segments.size();
    if ((j.fraction <= 0 && domain.outline.is_corner(j.aligned_segment)) ||
        (j.fraction >= 1 && domain.outline.is_corner((j.aligned_segment + 1) % n)))
      return "it ends at a corner, where the two sides fix the surface's slopes already";
    (e ? aligned_segment.to : aligned_segment.from) = junctions[e]->uv;
    on_outline[e] = junctions[e]->position;
  }
  if (const std::string reason = rejection_reason(domain, s, aligned_segment); !reason.empty())
    return reason;
  const Vec3 t0 = curve.evaluate(curve.start(), 1).normalized(),
             t1 = curve.evaluate(curve.end(), 1).normalized();
  aligned_segment.fitted = s.prescribed ? s.prescribed->curve
                                        : fit_aligned_segment(domain, s, {on_outline[0], t0, t0},
                                                              {on_outline[1], t1, t1}, true);
  for (const auto& j : junctions)
    domain.aligned_segments[j->aligned_segment].nodes.push_back(j->fraction);
  domain.aligned_inner.push_back(s);
  domain.aligned_segments.push_back(std::move(aligned_segment));
  return "";
}

}  // namespace batten
