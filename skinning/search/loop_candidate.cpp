// What a loop costs, and where its surface lies.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "batten/core/dense.h"
#include "batten/core/isize.h"
#include "batten/skinning/search/planar_loops.h"
#include "batten/skinning/search/region_loops.h"

namespace batten {
namespace {

using std::numbers::pi;

double wrapped(double angle) { return std::remainder(angle, 2 * pi); }

// A loop with its normal at both ends of each use, by the angle in the arc's frame.
struct Normals {
  const RegionGraph& graph;
  const EdgeLoop& loop;
  int n = isize(loop);
  struct Corner {
    Vec3 axis;        // of the turn from the arc before to the arc after
    double sine = 0;  // of the angle between them
    double inside = pi;
    bool has_plane = false;  // has a plane
  };
  std::vector<Corner> corners;                  // before use i
  std::vector<std::array<double, 2>> angles{};  // normal at the start and end of travel
  double twist_squares = 0, turning = 0;

  Normals(const RegionGraph& g, const EdgeLoop& l) : graph(g), loop(l), angles(l.size()) {
    for (int i = 0; i < n; ++i) {
      const Vec3 in = graph.arriving(loop[(i + n - 1) % n]), out = graph.leaving(loop[i]);
      Corner corner{in.cross(out), 0};
      corner.sine = corner.axis.norm();
      corner.inside = std::atan2(corner.sine, -in.dot(out));
      corner.has_plane = corner.sine > kMinCornerSine;
      if (corner.has_plane) corner.axis /= corner.sine;
      corners.push_back(corner);
    }
    int first = 0;
    for (int i = 1; i < n; ++i)
      if (corners[i].sine > corners[first].sine + 1e-9) first = i;
    if (corners[first].has_plane)
      propagate(first);
    else
      by_area();
    orient_inwards();
  }

  const GraphEdge& edge(int i) const { return graph.edges[loop[i].edge]; }
  Vec3 normal(int i, bool at_end) const {
    return edge(i).across(at_end != loop[i].reversed, angles[i][at_end]);
  }
  double angle_of(int i, bool at_end, const Vec3& across) const {
    return edge(i).angle(at_end != loop[i].reversed, across);
  }

  // Around the loop from corner to corner; the twist that is found is spread over the way.
  void propagate(int first) {
    Vec3 now = corners[first].axis;
    int from = first;  // use after the last corner with a plane
    for (int k = 0; k < n; ++k) {
      const int i = (first + k) % n, next = (i + 1) % n;
      if (k > 0 && !corners[i].has_plane) {
        // Through a straight corner by the least rotation.
        const Vec3 in = graph.arriving(loop[(i + n - 1) % n]), out = graph.leaving(loop[i]);
        now = Eigen::Quaterniond::FromTwoVectors(in, out) * now;
      }
      angles[i][0] = angles[i][1] = angle_of(i, false, now);
      now = normal(i, true);
      if (!corners[next].has_plane) continue;
      Vec3 target = corners[next].axis;
      // A corner that turns inwards has its axis against the normal. The first one is fixed.
      if (next != first && target.dot(now) < 0) target = -target;
      const int sign = loop[i].reversed ? -1 : 1;
      const double twist = sign * wrapped(angle_of(i, true, target) - angles[i][1]);
      spread(from, i, twist);
      twist_squares += twist * twist;
      now = target;
      from = next;
    }
  }

  void spread(int from, int to, double twist) {
    double length = 0, along = 0;
    for (int i = from;; i = (i + 1) % n) {
      length += edge(i).length;
      if (i == to) break;
    }
    for (int i = from;; i = (i + 1) % n) {
      const int sign = loop[i].reversed ? -1 : 1;
      angles[i][0] += sign * twist * along / length;
      along += edge(i).length;
      angles[i][1] += sign * twist * along / length;
      if (i == to) break;
    }
  }

  void by_area() {
    const std::vector<Vec3> points = graph.sampled(loop, GraphEdge::kPieces);
    Vec3 area = Vec3::Zero();
    for (size_t i = 0; i < points.size(); ++i)
      area += (points[i] - points[0]).cross(points[(i + 1) % points.size()] - points[0]);
    for (int i = 0; i < n; ++i) {
      angles[i] = {angle_of(i, false, area), angle_of(i, true, area)};
      const double twist = wrapped(angles[i][1] - angles[i][0]);
      twist_squares += twist * twist;
    }
  }

  // Directions into the surface: a quarter turn from the normal, to the left of travel.
  std::array<double, 2> side(int i) const {
    const double quarter = loop[i].reversed ? pi / 2 : -pi / 2;
    return {angles[i][0] + quarter, angles[i][1] + quarter};
  }

  void orient_inwards() {
    std::vector<int> convex(n, 1);
    for (int i = 0; i < n; ++i) {
      if (corners[i].axis.dot(normal(i, false)) < 0) convex[i] = -1;
      turning += convex[i] * (pi - corners[i].inside);
      const auto [a, b] = side(i);
      const double middle = a + wrapped(b - a) / 2;
      turning += edge(i).turning_u * std::cos(middle) + edge(i).turning_v * std::sin(middle);
    }
    const bool flip = turning < 0;
    if (flip) {
      turning = -turning;
      for (auto& [a, b] : angles) a += pi, b += pi;
    }
    for (int i = 0; i < n; ++i)
      if (corners[i].has_plane && (convex[i] < 0) != flip)
        corners[i].inside = 2 * pi - corners[i].inside;
  }
};

// Whether an arc end at the node before use i leaves into the surface between use i - 1 and use i.
bool leaves_into(const Normals& around, int i, const EdgeEnd& e) {
  const OrientedEdge &before = around.loop[(i + around.n - 1) % around.n], &after = around.loop[i];
  if (e == EdgeEnd{before.edge, !before.reversed} || e == EdgeEnd{after.edge, after.reversed})
    return false;
  const Vec3 in = around.graph.arriving(before), normal = around.normal(i, false);
  const Vec3 d = around.graph.edges[e.edge].out(e.end);
  if (std::abs(d.dot(normal)) > 0.5) return false;
  double angle = std::atan2(d.dot(normal.cross(in)), -d.dot(in));
  if (angle < 0) angle += 2 * pi;
  return angle > 0.15 && angle < around.corners[i].inside - 0.15;
}

int jumps(const Normals& around) {
  int count = 0;
  for (int i = 0; i < around.n; ++i)
    for (const EdgeEnd& e : around.graph.ends[around.graph.node_before(around.loop[i])])
      count += around.graph.core[e.edge] && leaves_into(around, i, e);
  return count;
}

double plane_distance(const RegionGraph& graph, const EdgeLoop& loop) {
  const std::vector<Vec3> points = graph.sampled(loop, 8);
  const double least = principal_axes(points).values[0] / static_cast<double>(points.size());
  return std::sqrt(std::max(least, 0.0));
}

}  // namespace

LoopCandidate measure_loop(const RegionGraph& graph, const EdgeLoop& given,
                           const LoopCosts& costs) {
  LoopCandidate c;
  c.loop = canonical(given);
  const Normals around(graph, c.loop);
  double inside = 0, length = 0;
  std::map<int, int> edges, nodes;
  for (int i = 0; i < around.n; ++i) {
    inside += around.corners[i].inside;
    length += around.edge(i).length;
    // Both ways along a bridge, and its nodes again, is as it must be.
    if (edges[c.loop[i].edge]++ > 0) c.revisits += graph.bridge[c.loop[i].edge] ? -2 : 1;
    c.revisits += nodes[graph.node_before(c.loop[i])]++ > 0;
    auto side = around.side(i);
    if (c.loop[i].reversed) std::swap(side[0], side[1]);
    c.side.push_back(side);
  }
  const double quarter = pi / 2;
  c.inside_deg = inside / around.n * 180 / pi;
  if (const int ends = fillet_ends(graph, c.loop); ends > 0)
    inside = (around.n - 2 - costs.fillet_end * ends) * pi;
  c.revisits = std::max(c.revisits, 0);
  c.nonplanarity = plane_distance(graph, c.loop) / (length / (2 * pi));
  c.cost = inside / pi + costs.twist * around.twist_squares / (quarter * quarter) +
           costs.nonplanarity * c.nonplanarity * c.nonplanarity + costs.jump * jumps(around) +
           costs.revisits * c.revisits;
  return c;
}

bool leaves_into(const RegionGraph& graph, const LoopCandidate& loop, const EdgeEnd& end) {
  const Normals around(graph, loop.loop);
  const int node = graph.edges[end.edge].nodes[end.end];
  for (int i = 0; i < around.n; ++i)
    if (graph.node_before(loop.loop[i]) == node && leaves_into(around, i, end)) return true;
  return false;
}

double fold_deg(const LoopCandidate& a, size_t i, const LoopCandidate& b, size_t j) {
  const double start = wrapped(a.side[i][0] - b.side[j][0]);
  const double angle_change =
      wrapped(a.side[i][1] - a.side[i][0]) - wrapped(b.side[j][1] - b.side[j][0]);
  double squares = 0;
  for (const double s : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double fold = pi - std::abs(wrapped(start + s * angle_change));
    squares += fold * fold / 5;
  }
  return std::sqrt(squares) * 180 / pi;
}

}  // namespace batten
