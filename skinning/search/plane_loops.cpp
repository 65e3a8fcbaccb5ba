#include "batten/skinning/search/plane_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/index.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double near = 3e-4;  // of the network's size

struct Plane {
  Vec3 at, normal;
  double tolerance;
  bool holds(const RegionArc& arc) const {
    return std::all_of(arc.points.begin(), arc.points.end(),
                       [&](const Vec3& p) { return std::abs((p - at).dot(normal)) <= tolerance; });
  }
};

// The arc of the plane that turns most to the inside, after `use`.
std::optional<ArcUse> next_in(const Plane& plane, const RegionGraph& graph, const ArcUse& use) {
  const Vec3 in = graph.arriving(use), inwards = plane.normal.cross(in);
  std::optional<ArcUse> best;
  double least = 2 * pi;
  for (const ArcEnd& e : graph.ends[graph.node_after(use)]) {
    if (!graph.core[e.arc] || e == ArcEnd{use.arc, !use.reversed}) continue;
    const RegionArc& arc = graph.arcs[e.arc];
    const Vec3 out = arc.out(e.end);
    double angle = std::atan2(out.dot(inwards), -out.dot(in));
    if (angle < 0) angle += 2 * pi;
    if (angle >= least || !plane.holds(arc)) continue;
    least = angle;
    best = {e.arc, e.end};
  }
  return best;
}

Vec3 area_vector(const std::vector<Vec3>& polygon) {
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < polygon.size(); ++i)
    sum += (polygon[i] - polygon[0]).cross(polygon[(i + 1) % polygon.size()] - polygon[0]) / 2;
  return sum;
}

}  // namespace

std::optional<PlaneFace> plane_face(const RegionGraph& graph, const ArcLoop& loop) {
  PlaneFace face;
  face.outline = graph.sampled(loop, RegionArc::kPieces);
  face.tolerance = near * graph.size;
  const Vec3 area = area_vector(face.outline);
  face.area = area.norm();
  if (!(face.area > 0)) return std::nullopt;
  face.normal = area / face.area;
  face.at = Vec3::Zero();
  for (const Vec3& p : face.outline) face.at += p / static_cast<double>(face.outline.size());
  for (const Vec3& p : face.outline)
    if (std::abs((p - face.at).dot(face.normal)) > face.tolerance) return std::nullopt;
  return face;
}

bool PlaneFace::holds(const std::vector<Vec3>& points) const {
  return std::all_of(points.begin(), points.end(), [&](const Vec3& p) {
    if (std::abs((p - at).dot(normal)) > tolerance) return false;
    double around = 0, nearest = HUGE_VAL;
    for (size_t i = 0; i < outline.size(); ++i) {
      const Vec3 a = outline[i] - p, b = outline[(i + 1) % outline.size()] - p;
      around += std::atan2(a.cross(b).dot(normal), a.dot(b));
      nearest = std::min(nearest, a.norm());
    }
    return nearest > tolerance && around > pi;
  });
}

bool is_straight(const RegionArc& arc) {
  constexpr double off = 1e-3;
  const Vec3 chord = arc.points.back() - arc.points.front();
  if (chord.norm() < 0.5 * arc.length) return false;
  const Vec3 along = chord.normalized();
  return std::all_of(arc.points.begin(), arc.points.end(), [&](const Vec3& p) {
    return along.cross(p - arc.points.front()).norm() <= off * arc.length;
  });
}

int fillet_ends(const RegionGraph& graph, const ArcLoop& loop) {
  constexpr double straight_on = 0.2588;  // sin 15°
  const auto goes_on = [&](size_t i) {
    const ArcUse &use = loop[i], &next = loop[(i + 1) % loop.size()];
    const Vec3 in = graph.arriving(use), out = graph.leaving(next);
    return in.dot(out) > 0 && in.cross(out).norm() < straight_on &&
           is_straight(graph.arcs[use.arc]) != is_straight(graph.arcs[next.arc]);
  };
  int ends = 0;
  for (size_t i = 0; i < loop.size(); ++i) ends += goes_on(i);
  if (ends == 0) return 0;
  return plane_face(graph, loop) ? ends : 0;
}

ArcLoop loop_in_plane(const RegionGraph& graph, const ArcUse& in, const ArcUse& out,
                      const Vec3& normal) {
  const Plane plane{graph.nodes[graph.node_before(out)], normal, near * graph.size};
  if (!plane.holds(graph.arcs[in.arc]) || !plane.holds(graph.arcs[out.arc])) return {};
  ArcLoop loop{out};
  while (loop.back() != in) {
    constexpr size_t most_arcs = 200;
    const auto next = next_in(plane, graph, loop.back());
    if (!next || loop.size() == most_arcs ||
        std::find(loop.begin(), loop.end(), *next) != loop.end())
      return {};
    loop.push_back(*next);
  }
  return area_vector(graph.sampled(loop, RegionArc::kPieces)).dot(normal) > 0 ? loop : ArcLoop{};
}

}  // namespace batten
