// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/search/region_loops.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <queue>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/parallel.h"
#include "batten/skinning/search/region_graph.h"

namespace batten {
namespace {

using std::numbers::pi;
constexpr double kCostPerEdge = 0.05;    // of each further edge: shorter loops come first
constexpr double kMaxExcessCost = 1.25;  // paths with a larger excess cost are dropped
constexpr int kLoopsPerCorner = 3, kMaxLoopEdges = 200, kMaxPartialLoops = 600,
              kMaxVisitsPerEdge = 3;

// A set of edges as a one-hash Bloom filter: may report edges that are not in it.
class EdgeFilter {
 public:
  void add(int edge) { bits_.set(bit(edge)); }
  bool may_have(int edge) const { return bits_.test(bit(edge)); }

 private:
  static size_t bit(int edge) { return static_cast<std::uint32_t>(edge) * 2654435769u >> 24; }
  std::bitset<256> bits_;
};

// A partial loop, stored as its last edge and a link to the one before.
struct PartialLoop {
  double cost;
  OrientedEdge use;
  Vec3 normal;  // surface normal at the end of the edge
  int before, length;
  EdgeFilter edges;  // all edges of the partial loop
};

// A continuation from one edge into the next at a node.
struct Continuation {
  OrientedEdge next;
  double price;
  Vec3 normal;  // surface normal at the start of the next edge
};

bool straight_on(const RegionGraph& graph, const OrientedEdge& in, const OrientedEdge& out) {
  const Vec3 a = graph.arriving(in), b = graph.leaving(out);
  return a.cross(b).norm() <= kMinCornerSine && a.dot(b) > 0;
}

// Finds the edge uses that may lie on a loop without any corner. Uses that no other use continues
// straight into or from are removed repeatedly. Result by 2 · edge + reversed. O(edges).
std::vector<char> without_corner(const RegionGraph& graph) {
  const size_t count = 2 * graph.edges.size();
  const auto number = [](const OrientedEdge& use) { return 2 * use.edge + use.reversed; };
  std::vector<std::vector<int>> after(count), before(count);
  for (const auto& ends : graph.ends)
    for (const EdgeEnd& i : ends)
      for (const EdgeEnd& j : ends) {
        const OrientedEdge in{i.edge, !i.end}, out{j.edge, j.end};
        if (i == j || !graph.core[i.edge] || !graph.core[j.edge] || !straight_on(graph, in, out))
          continue;
        after[number(in)].push_back(number(out));
        before[number(out)].push_back(number(in));
      }
  std::vector<char> left(count, 1);
  std::vector<int> out_degree(count), in_degree(count), gone;
  for (int u = 0; u < isize(left); ++u) {
    out_degree[u] = isize(after[u]);
    in_degree[u] = isize(before[u]);
    if (out_degree[u] == 0 || in_degree[u] == 0) gone.push_back(u);
  }
  while (!gone.empty()) {
    const int u = gone.back();
    gone.pop_back();
    if (!std::exchange(left[u], 0)) continue;
    for (const int v : before[u])
      if (--out_degree[v] == 0) gone.push_back(v);
    for (const int v : after[u])
      if (--in_degree[v] == 0) gone.push_back(v);
  }
  return left;
}

class Tracer {
 public:
  Tracer(const RegionGraph& graph, const LoopCosts& costs, const std::vector<char>& smooth)
      : graph_(graph), costs_(costs), smooth_(smooth) {}

  // Traces loops around the corner from `in` to `out`, with the surface between the two.
  void trace(const OrientedEdge& in, const OrientedEdge& out, std::vector<EdgeLoop>& loops) {
    const Vec3 a = graph_.arriving(in), b = graph_.leaving(out);
    const Vec3 axis = a.cross(b);
    if (axis.norm() > kMinCornerSine) return follow(in, out, axis.normalized(), loops);
    // Loops that have a corner are traced from that corner.
    if (a.dot(b) > 0 && !smooth_[2 * in.edge + in.reversed] &&
        !smooth_[2 * out.edge + out.reversed])
      return;
    // No corner: try the side to which both edges turn, and the other one.
    const GraphEdge &before = graph_.edges[in.edge], &after = graph_.edges[out.edge];
    const Vec3& node = graph_.nodes[graph_.node_before(out)];
    constexpr int kMiddlePoint = GraphEdge::kPieces / 2;
    Vec3 turn = (before.points[kMiddlePoint] - node) / before.length +
                (after.points[kMiddlePoint] - node) / after.length;
    turn -= turn.dot(b) * b;
    if (turn.norm() < 1e-6) turn = after.across(out.reversed, 0);
    const Vec3 normal = b.cross(turn).normalized();
    follow(in, out, normal, loops);
    follow(in, out, -normal, loops);
  }

  bool complete() const { return complete_; }

 private:
  void follow(const OrientedEdge& in, const OrientedEdge& out, const Vec3& normal,
              std::vector<EdgeLoop>& loops) {
    if (EdgeLoop plane = loop_in_plane(graph_, in, out, normal); !plane.empty())
      loops.push_back(std::move(plane));
    partials_.clear();
    taken_.clear();
    using Next = std::pair<double, int>;
    std::priority_queue<Next, std::vector<Next>, std::greater<>> open;
    const auto add = [&](double cost, const OrientedEdge& use, const Vec3& at_start, int before) {
      const Vec3 at_end = graph_.edges[use.edge].parallel_transported(use.reversed, at_start);
      const int length = before < 0 ? 1 : partials_[before].length + 1;
      EdgeFilter edges = before < 0 ? EdgeFilter() : partials_[before].edges;
      edges.add(use.edge);
      partials_.push_back({cost, use, at_end, before, length, edges});
      open.push({cost, isize(partials_) - 1});
    };
    add(0, out, normal, -1);
    int found = 0;
    while (!open.empty()) {
      const int w = open.top().second;
      open.pop();
      const PartialLoop partial = partials_[w];
      // The first loop may have any number of edges.
      if (partial.cost > (found ? kMaxExcessCost : kMaxExcessCost + kCostPerEdge * partial.length))
        break;
      if (isize(partials_) > (found ? kMaxPartialLoops : 5 * kMaxPartialLoops)) {
        complete_ = complete_ && found > 0;
        break;
      }
      if (partial.use == in) {
        loops.push_back(chain(w));
        if (++found == kLoopsPerCorner) break;
        continue;
      }
      if (partial.length >= kMaxLoopEdges) continue;
      if (++taken_[2 * partial.use.edge + partial.use.reversed] > kMaxVisitsPerEdge) continue;
      list_continuations(partial);
      for (const Continuation& turn : continuations_) {
        if (passed(w, turn.next)) continue;
        double cost = partial.cost + turn.price - continuations_.front().price + kCostPerEdge;
        if (turn.next == in) {
          // The path closes: add the twist between the transported normal and that of the start.
          const Vec3 end = graph_.edges[in.edge].parallel_transported(in.reversed, turn.normal);
          const double twist = std::atan2(end.cross(normal).norm(), end.dot(normal));
          cost += costs_.twist * twist * twist / (pi * pi / 4);
        }
        if (cost <= kMaxExcessCost + kCostPerEdge * partial.length)
          add(cost, turn.next, turn.normal, w);
      }
    }
  }

  // Lists all continuations from the end of a partial loop, cheapest first.
  void list_continuations(const PartialLoop& partial) {
    const Vec3 in = graph_.arriving(partial.use), back = -in;
    const Vec3 inwards = partial.normal.cross(in);
    continuations_.clear();
    angles_.clear();
    const int node = graph_.node_after(partial.use);
    for (const EdgeEnd& e : graph_.ends[node]) {
      if (!graph_.core[e.edge] || (e == EdgeEnd{partial.use.edge, !partial.use.reversed})) continue;
      const Vec3 out = graph_.edges[e.edge].out(e.end);
      const Vec3 axis = in.cross(out);
      const double sine = axis.norm();
      double angle = std::atan2(sine, back.dot(out)), twist = 0;
      Vec3 normal = partial.normal;
      if (sine > kMinCornerSine) {
        normal = axis / sine;
        // The normal is about perpendicular to the surface so far: take the corner as convex.
        if (normal.dot(partial.normal) < -0.15) {
          normal = -normal;
          angle = 2 * pi - angle;
        }
        twist = std::acos(std::clamp(normal.dot(partial.normal), -1.0, 1.0));
      } else if (in.dot(out) > 0) {
        normal = Eigen::Quaterniond::FromTwoVectors(in, out) * partial.normal;
        const double along = std::atan2(out.dot(inwards), out.dot(back));
        angle = along < 0 ? along + 2 * pi : along;
      } else {
        normal = -partial.normal;  // around a cusp
      }
      normal = (normal - normal.dot(out) * out).normalized();
      continuations_.push_back(
          {{e.edge, e.end}, angle / pi + costs_.twist * twist * twist / (pi * pi / 4), normal});
      angles_.push_back({angle, std::abs(out.dot(partial.normal))});
    }
    // Add the cost of skipped edges: those that lie in the surface between.
    for (size_t i = 0; i < continuations_.size(); ++i)
      for (size_t j = 0; j < continuations_.size(); ++j)
        if (angles_[j].second < 0.5 && angles_[j].first > 0.15 &&
            angles_[j].first < angles_[i].first - 0.15)
          continuations_[i].price += costs_.jump;
    std::stable_sort(
        continuations_.begin(), continuations_.end(),
        [](const Continuation& a, const Continuation& b) { return a.price < b.price; });
  }

  // True if the path has used the edge in the same direction, or in the opposite one if it is no
  // bridge.
  bool passed(int w, const OrientedEdge& use) const {
    if (!partials_[w].edges.may_have(use.edge)) return false;
    for (; w >= 0; w = partials_[w].before) {
      const OrientedEdge& other = partials_[w].use;
      if (other.edge == use.edge && (other.reversed == use.reversed || !graph_.bridge[use.edge]))
        return true;
    }
    return false;
  }

  EdgeLoop chain(int w) const {
    EdgeLoop loop;
    for (; w >= 0; w = partials_[w].before) loop.push_back(partials_[w].use);
    std::reverse(loop.begin(), loop.end());
    return loop;
  }

  const RegionGraph& graph_;
  const LoopCosts& costs_;
  const std::vector<char>& smooth_;  // without_corner()
  std::vector<PartialLoop> partials_;
  std::vector<Continuation> continuations_;
  // Interior angle; sine of the angle to the surface.
  std::vector<std::pair<double, double>> angles_;
  std::map<int, int> taken_;
  bool complete_ = true;
};

bool loop_before(const EdgeLoop& a, const EdgeLoop& b) {
  const std::vector<int> x = edges_of(a), y = edges_of(b);
  return x != y ? x < y
                : std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                               [](const OrientedEdge& p, const OrientedEdge& q) {
                                                 return p.edge != q.edge ? p.edge < q.edge
                                                                         : p.reversed < q.reversed;
                                               });
}

}  // namespace

TracedLoops trace_loops(const RegionGraph& graph, const LoopCosts& costs,
                        const Progress& progress) {
  constexpr int kNodes = 16;  // nodes per task
  const int count = isize(graph.nodes), parts = (count + kNodes - 1) / kNodes;
  std::vector<std::vector<EdgeLoop>> found(parts);
  std::vector<char> complete(parts, 1);
  progress.update("faces: loops", 0);
  const std::vector<char> smooth = without_corner(graph);
  parallel_for(parts, [&](int part) {
    Tracer tracer(graph, costs, smooth);
    for (int n = part * kNodes; n < std::min((part + 1) * kNodes, count); ++n) {
      const auto& ends = graph.ends[n];
      for (size_t i = 0; i < ends.size(); ++i)
        for (size_t j = i + 1; j < ends.size(); ++j)
          if (graph.core[ends[i].edge] && graph.core[ends[j].edge])
            tracer.trace({ends[i].edge, !ends[i].end}, {ends[j].edge, ends[j].end}, found[part]);
    }
    for (EdgeLoop& loop : found[part]) loop = canonical(loop);
    complete[part] = tracer.complete();
  });
  progress.update("faces: loops", 0.5);

  std::vector<EdgeLoop> loops;
  for (auto& some : found) loops.insert(loops.end(), some.begin(), some.end());
  std::sort(loops.begin(), loops.end(), loop_before);
  loops.erase(std::unique(loops.begin(), loops.end()), loops.end());

  TracedLoops traced;
  traced.complete = std::find(complete.begin(), complete.end(), 0) == complete.end();
  traced.loops.resize(loops.size());
  constexpr int kAtATime = 64;
  const int total = isize(loops);
  parallel_for((total + kAtATime - 1) / kAtATime, [&](int part) {
    for (int i = part * kAtATime; i < std::min((part + 1) * kAtATime, total); ++i)
      traced.loops[i] = measure_loop(graph, loops[i], costs);
  });
  // Loops with the same edges in another order bound the same surface: keep the cheaper one.
  std::vector<LoopCandidate> once;
  for (LoopCandidate& c : traced.loops) {
    if (!once.empty() && edges_of(once.back().loop) == edges_of(c.loop)) {
      if (c.cost < once.back().cost - 1e-9) once.back() = std::move(c);
    } else {
      once.push_back(std::move(c));
    }
  }
  traced.loops = std::move(once);
  progress.update("faces: loops", 1);
  return traced;
}

// Costs of loops, and the directions of their surfaces.

namespace {

using std::numbers::pi;

double wrapped(double angle) { return std::remainder(angle, 2 * pi); }

// Surface normals along a loop, at both ends of each use, as angles in the edge's frame.
struct Normals {
  const RegionGraph& graph;
  const EdgeLoop& loop;
  int n = isize(loop);
  struct Corner {
    Vec3 axis;        // of the rotation from the edge before to the edge after
    double sine = 0;  // of the angle between them
    double inside = pi;
    bool has_plane = false;  // the edges define a plane
  };
  std::vector<Corner> corners;                  // corner before use i
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

  // Transports the normal around the loop from corner to corner; the twist is distributed over the
  // edges.
  void propagate(int first) {
    Vec3 now = corners[first].axis;
    int from = first;  // use after the last corner with a plane
    for (int k = 0; k < n; ++k) {
      const int i = (first + k) % n, next = (i + 1) % n;
      if (k > 0 && !corners[i].has_plane) {
        // Through a straight corner by the smallest rotation.
        const Vec3 in = graph.arriving(loop[(i + n - 1) % n]), out = graph.leaving(loop[i]);
        now = Eigen::Quaterniond::FromTwoVectors(in, out) * now;
      }
      angles[i][0] = angles[i][1] = angle_of(i, false, now);
      now = normal(i, true);
      if (!corners[next].has_plane) continue;
      Vec3 target = corners[next].axis;
      // A concave corner has its axis opposite to the normal. The first corner is the reference.
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

  // Directions into the surface: the normal, rotated by 90°, to the left of travel.
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

// True if an edge end at the node before use i leaves into the surface between uses i - 1 and i.
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
    // Passing a bridge in both directions, and its nodes twice, is unavoidable and not counted.
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
