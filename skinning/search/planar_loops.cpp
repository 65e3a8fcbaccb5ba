#include "batten/skinning/search/planar_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/isize.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double kPlaneTolerance = 3e-4;  // of the network's size

struct Plane {
  Vec3 at, normal;
  double tolerance;
  bool contains(const GraphEdge& edge) const {
    return std::all_of(edge.points.begin(), edge.points.end(),
                       [&](const Vec3& p) { return std::abs((p - at).dot(normal)) <= tolerance; });
  }
};

// The arc of the plane that turns most to the inside, after `use`.
std::optional<OrientedEdge> next_in(const Plane& plane, const RegionGraph& graph,
                                    const OrientedEdge& use) {
  const Vec3 in = graph.arriving(use), inwards = plane.normal.cross(in);
  std::optional<OrientedEdge> best;
  double least = 2 * pi;
  for (const EdgeEnd& e : graph.ends[graph.node_after(use)]) {
    if (!graph.core[e.edge] || e == EdgeEnd{use.edge, !use.reversed}) continue;
    const GraphEdge& edge = graph.edges[e.edge];
    const Vec3 out = edge.out(e.end);
    double angle = std::atan2(out.dot(inwards), -out.dot(in));
    if (angle < 0) angle += 2 * pi;
    if (angle >= least || !plane.contains(edge)) continue;
    least = angle;
    best = {e.edge, e.end};
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

std::optional<PlanarFace> planar_face(const RegionGraph& graph, const EdgeLoop& loop) {
  PlanarFace face;
  face.outline = graph.sampled(loop, GraphEdge::kPieces);
  face.tolerance = kPlaneTolerance * graph.size;
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

bool PlanarFace::contains(const std::vector<Vec3>& points) const {
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

bool is_straight(const GraphEdge& edge) {
  constexpr double kStraightTolerance = 1e-3;
  const Vec3 chord = edge.points.back() - edge.points.front();
  if (chord.norm() < 0.5 * edge.length) return false;
  const Vec3 along = chord.normalized();
  return std::all_of(edge.points.begin(), edge.points.end(), [&](const Vec3& p) {
    return along.cross(p - edge.points.front()).norm() <= kStraightTolerance * edge.length;
  });
}

int fillet_ends(const RegionGraph& graph, const EdgeLoop& loop) {
  constexpr double kStraightSine = 0.2588;  // sin 15°
  const auto goes_on = [&](size_t i) {
    const OrientedEdge &use = loop[i], &next = loop[(i + 1) % loop.size()];
    const Vec3 in = graph.arriving(use), out = graph.leaving(next);
    return in.dot(out) > 0 && in.cross(out).norm() < kStraightSine &&
           is_straight(graph.edges[use.edge]) != is_straight(graph.edges[next.edge]);
  };
  int ends = 0;
  for (size_t i = 0; i < loop.size(); ++i) ends += goes_on(i);
  if (ends == 0) return 0;
  return planar_face(graph, loop) ? ends : 0;
}

EdgeLoop loop_in_plane(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out,
                       const Vec3& normal) {
  const Plane plane{graph.nodes[graph.node_before(out)], normal, kPlaneTolerance * graph.size};
  if (!plane.contains(graph.edges[in.edge]) || !plane.contains(graph.edges[out.edge])) return {};
  EdgeLoop loop{out};
  while (loop.back() != in) {
    constexpr size_t kMaxEdges = 200;
    const auto next = next_in(plane, graph, loop.back());
    if (!next || loop.size() == kMaxEdges ||
        std::find(loop.begin(), loop.end(), *next) != loop.end())
      return {};
    loop.push_back(*next);
  }
  return area_vector(graph.sampled(loop, GraphEdge::kPieces)).dot(normal) > 0 ? loop : EdgeLoop{};
}

}  // namespace batten
