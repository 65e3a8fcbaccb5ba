// SPDX-License-Identifier: MPL-2.0
// join_meshes(): new triangles that share the boundary vertices of given meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "batten/core/containers.h"
#include "batten/scenes/lines/mesh_neighbours.h"

namespace batten {
namespace {

using Triangle = std::array<int, 3>;
using DirectedEdge = std::pair<int, int>;

// The triangle of each directed edge; those with a flag in `without` are left out.
std::map<DirectedEdge, size_t> directed_edges(const std::vector<Triangle>& triangles,
                                              const std::vector<char>& without = {}) {
  std::map<DirectedEdge, size_t> edges;
  for (size_t t = 0; t < triangles.size(); ++t)
    if (without.empty() || !without[t])
      for (size_t c = 0; c < 3; ++c) edges[{triangles[t][c], triangles[t][(c + 1) % 3]}] = t;
  return edges;
}

// Reverses triangles so that those with a common edge traverse it in opposite directions. Returns
// the number of the connected component of each triangle.
std::vector<int> orient(std::vector<Triangle>& triangles) {
  std::map<DirectedEdge, std::vector<size_t>> sides;
  for (size_t t = 0; t < triangles.size(); ++t)
    for (size_t c = 0; c < 3; ++c)
      sides[std::minmax(triangles[t][c], triangles[t][(c + 1) % 3])].push_back(t);
  std::vector<int> component(triangles.size(), -1);
  for (size_t seed = 0; seed < triangles.size(); ++seed) {
    if (component[seed] >= 0) continue;
    component[seed] = static_cast<int>(seed);
    std::vector<size_t> queue{seed};
    while (!queue.empty()) {
      const Triangle here = triangles[queue.back()];
      queue.pop_back();
      for (size_t c = 0; c < 3; ++c) {
        const int a = here[c], b = here[(c + 1) % 3];
        const std::vector<size_t>& both = sides[std::minmax(a, b)];
        if (both.size() != 2) continue;
        for (const size_t other : both) {
          if (component[other] >= 0) continue;
          Triangle& next = triangles[other];
          for (size_t k = 0; k < 3; ++k)
            if (next[k] == a && next[(k + 1) % 3] == b) {
              std::swap(next[0], next[1]);
              break;
            }
          component[other] = static_cast<int>(seed);
          queue.push_back(other);
        }
      }
    }
  }
  return component;
}

// Boundary loops of oriented triangles, with the triangles on the left.
std::vector<std::vector<int>> boundary_loops(const std::map<DirectedEdge, size_t>& edges) {
  std::map<int, int> next;
  for (const auto& [edge, t] : edges)
    if (!edges.count({edge.second, edge.first})) next[edge.first] = edge.second;
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> loop;
    int v = next.begin()->first;
    while (next.count(v)) {
      loop.push_back(v);
      const int after = next[v];
      next.erase(v);
      v = after;
    }
    if (v == loop.front()) loops.push_back(std::move(loop));
  }
  return loops;
}

// A closed polygon of vertices of a given mesh.
class GivenLoop {
 public:
  GivenLoop() = default;
  // `first_node`: number of the mesh's first node in the joined mesh.
  GivenLoop(const TriangleMesh& mesh, const MeshBoundary& boundary, int first_node)
      : normals_(boundary.normals) {
    for (const int v : boundary.vertices) {
      points_.push_back(mesh.point(v));
      nodes_.push_back(first_node + mesh.topology().node_of(v));
    }
    for (int i = 0; i < count(); ++i) {
      const double edge = (point(i + 1) - point(i)).norm();
      longest_ = std::max(longest_, edge);
      mean_ += edge / count();
    }
  }
  int count() const { return isize(points_); }
  double longest_edge() const { return longest_; }
  double mean_edge() const { return mean_; }
  const Vec3& point(int i) const { return points_[number(i)]; }
  int node(int i) const { return nodes_[number(i)]; }
  const std::vector<Vec3>& points() const { return points_; }
  const std::vector<Vec3>& normals() const { return normals_; }

  // Cuts off parts of the hole: narrow notches, which are vertices at which the hole has an angle
  // below 75 degrees, and the smaller part where the loop meets itself in a vertex. Returns the
  // triangles that fill them, whose nodes run against the loop. `edges`: pairs of nodes that edges of
  // the given mesh connect.
  std::vector<Triangle> cut_notches(std::set<DirectedEdge> edges) {
    constexpr double least_turn = 105 * std::numbers::pi / 180;
    std::vector<Triangle> cut;
    while (auto part = separate_part()) part->cut_ears(0, edges, cut);
    cut_ears(-least_turn, edges, cut);
    return cut;
  }
  // Triangles that fill the whole loop.
  std::vector<Triangle> all_ears() {
    std::vector<Triangle> cut;
    std::set<DirectedEdge> none;
    cut_ears(0, none, cut);
    return cut;
  }
  // Closest point: its position in vertices along the loop, and its distance.
  std::pair<double, double> closest(const Vec3& x) const {
    double best = std::numeric_limits<double>::infinity(), at = 0;
    for (int i = 0; i < count(); ++i) {
      const Vec3 edge = point(i + 1) - point(i);
      const double t = std::clamp((x - point(i)).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      const double distance = (point(i) + t * edge - x).norm();
      if (distance < best) std::tie(best, at) = std::pair(distance, i + t);
    }
    return {at, best};
  }
  // True if x is closer to the loop than `distance`, or on the side of the given mesh.
  bool is_close(const Vec3& x, double distance) const {
    const auto [at, found] = closest(x);
    if (found < distance) return true;
    const int i = static_cast<int>(at);
    const double t = at - i;
    // At a vertex, the sum of the directions of both edges decides.
    Vec3 into = left(i);
    if (t == 0) into += left(i + count() - 1);
    if (t == 1) into += left(i + 1);
    return (x - (1 - t) * point(i) - t * point(i + 1)).dot(into) > 0;
  }

 private:
  // Unit vector from edge i into the given mesh, which lies to its left.
  Vec3 left(int i) const { return normals_[number(i)].cross(point(i + 1) - point(i)).normalized(); }

  size_t number(int i) const { return static_cast<size_t>(i % count()); }

  // Cuts off the sharpest notches, with turns of at least `turn` < 0, radians.
  void cut_ears(double turn, std::set<DirectedEdge>& edges, std::vector<Triangle>& cut) {
    while (count() > 3) {
      const auto [i, sharpest] = sharpest_notch(edges);
      if (sharpest > turn) break;
      const int before = node(i + count() - 1), after = node(i + 1);
      if (before != after) {
        cut.push_back({after, node(i), before});
        edges.insert(std::minmax(before, after));
      } else {
        erase(i + 1);
      }
      erase(i);
    }
    if (count() == 3) cut.push_back({node(2), node(1), node(0)});
  }

  // Takes the shorter part of the loop between two visits of the same node out of it.
  std::optional<GivenLoop> separate_part() {
    std::map<int, int> visit;
    for (int i = 0; i < count(); ++i) {
      const auto [before, is_new] = visit.emplace(node(i), i);
      if (is_new) continue;
      int first = before->second, last = i;
      if (last - first > count() / 2)
        std::tie(first, last) = std::pair(i, before->second + count());
      GivenLoop part;
      for (int k = first; k < last; ++k) {
        part.points_.push_back(point(k));
        part.normals_.push_back(normals_[number(k)]);
        part.nodes_.push_back(node(k));
      }
      const int length = last - first;
      for (int k = 0; k < length; ++k) erase(first < count() ? first : 0);
      return part;
    }
    return {};
  }

  void erase(int i) {
    const auto at = static_cast<std::ptrdiff_t>(number(i));
    points_.erase(points_.begin() + at);
    normals_.erase(normals_.begin() + at);
    nodes_.erase(nodes_.begin() + at);
  }

  // The vertex with the largest turn to the right, and this turn: negative, radians. Vertices whose
  // adjacent vertices are connected by another edge of the mesh are left out.
  std::pair<int, double> sharpest_notch(const std::set<DirectedEdge>& edges) const {
    std::pair<int, double> sharpest{0, 0};
    for (int i = 0; i < count(); ++i) {
      const int j = i + count() - 1;
      const Vec3 in = point(i) - point(j), out = point(i + 1) - point(i);
      const double turn = node(j) == node(i + 1)
                              ? -std::numbers::pi
                              : std::atan2(normals_[number(i)].dot(in.cross(out)), in.dot(out));
      if (turn < sharpest.second &&
          (node(j) == node(i + 1) || !edges.count(std::minmax(node(j), node(i + 1)))))
        sharpest = {i, turn};
    }
    return sharpest;
  }

  std::vector<Vec3> points_, normals_;
  std::vector<int> nodes_;
  double longest_ = 0, mean_ = 0;
};

// For each vertex of a loop of new triangles, a vertex of the given loop, in unwrapped numbers that
// ascend by the number of given vertices in one round (descend if `reversed`).
struct LoopMatch {
  std::vector<int> given;
  bool reversed = false;
};

std::optional<LoopMatch> match(const std::vector<Vec3>& loop, const GivenLoop& given,
                               double tolerance) {
  constexpr double farthest = 3;  // the curve of a zigzag passes its vertices at a distance
  std::vector<double> at;
  for (const Vec3& x : loop) {
    const auto [where, distance] = given.closest(x);
    if (distance > tolerance + farthest * given.longest_edge()) return {};
    at.push_back(where);
  }
  // Unwrap: the step to the next vertex is the shorter one around the loop.
  const double round = given.count();
  double total = 0;
  std::vector<double> unwrapped{at.front()};
  for (size_t i = 0; i < at.size(); ++i) {
    const double step = std::remainder(at[(i + 1) % at.size()] - at[i], round);
    total += step;
    if (i + 1 < at.size()) unwrapped.push_back(unwrapped.back() + step);
  }
  if (std::abs(std::abs(total) - round) > 0.5) return {};
  LoopMatch result;
  result.reversed = total < 0;
  const int sign = result.reversed ? -1 : 1;
  const int first = sign * static_cast<int>(std::lround(unwrapped.front()));
  int before = first;
  for (const double value : unwrapped) {
    // A zigzag of the given loop may turn the closest points back.
    before = std::clamp(sign * static_cast<int>(std::lround(value)), before, first + given.count());
    result.given.push_back(sign * before);
  }
  return result;
}

// A strip of triangles between two closed polygons that run side by side.
class Strip {
 public:
  struct Corner {
    int triangle_of;  // 0: two corners on the first polygon, 1: on the second one
    int i, j;         // the first of these corners, and the third one, in unwrapped numbers
  };

  // `normals`: of the surface, at the vertices of the first polygon. Triangles (one(i + 1), one(i),
  // two(j)) and (two(j), two(j + 1), one(i)) have this side.
  Strip(const std::vector<Vec3>& one, const std::vector<Vec3>& two,
        const std::vector<Vec3>& normals)
      : one_(one), two_(two), normals_(normals) {}

  // The triangulation with the smallest sum of squared lengths of the edges between the polygons,
  // without folded triangles if possible. `first`: vertex of the second polygon that is connected to
  // vertex 0 of the first one. Source: Fuchs, Kedem, Uselton 1977. O(product of the numbers of
  // vertices).
  std::vector<Corner> triangles(int first) const {
    const int n = isize(one_), m = isize(two_);
    std::vector<double> cost(static_cast<size_t>(m) + 1);
    std::vector<char> from_one((static_cast<size_t>(n) + 1) * (static_cast<size_t>(m) + 1));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= m; ++j) {
        if (i == 0 && j == 0) continue;
        const double infinite = std::numeric_limits<double>::infinity();
        const double by_one = i > 0 ? cost[j] + fold({0, i - 1, first + j}) : infinite;
        const double by_two = j > 0 ? cost[j - 1] + fold({1, first + j - 1, i}) : infinite;
        from_one[index(i, j)] = by_one <= by_two;
        cost[j] = std::min(by_one, by_two) + (at(one_, i) - at(two_, first + j)).squaredNorm();
      }
    std::vector<Corner> found;
    for (int i = n, j = m; i > 0 || j > 0;)
      if (from_one[index(i, j)])
        found.push_back({0, --i, first + j});
      else
        found.push_back({1, first + --j, i});
    return found;
  }

 private:
  static const Vec3& at(const std::vector<Vec3>& all, int i) {
    return all[static_cast<size_t>(i) % all.size()];
  }
  size_t index(int i, int j) const {
    return static_cast<size_t>(i) * (two_.size() + 1) + static_cast<size_t>(j);
  }
  // Penalty for a triangle that is folded, or nearly perpendicular to the surface.
  double fold(const Corner& t) const {
    constexpr double least = 0.3, weight = 1000;
    const Vec3& a = t.triangle_of == 0 ? at(one_, t.i + 1) : at(two_, t.i);
    const Vec3& b = t.triangle_of == 0 ? at(one_, t.i) : at(two_, t.i + 1);
    const Vec3& c = t.triangle_of == 0 ? at(two_, t.j) : at(one_, t.j);
    const Vec3 area = (b - a).cross(c - a);
    const Vec3& normal = at(normals_, t.triangle_of == 0 ? t.i : t.j);
    return area.dot(normal) > least * area.norm() ? 0 : weight * (b - a).squaredNorm();
  }

  const std::vector<Vec3>&one_, &two_, &normals_;
};

// The new triangles, with their vertices joined to those of given meshes.
class MeshJoiner {
 public:
  MeshJoiner(const std::vector<MeshNeighbour>& given, const WeldedMesh& added, double tolerance)
      : given_(given), added_(added), triangles_(added.triangles), region_(added.region) {
    component_ = orient(triangles_);
    edges_ = directed_edges(triangles_);
    removed_.assign(triangles_.size(), 0);
    node_.assign(static_cast<size_t>(added.points.rows()), -1);
    int first = 0;
    for (const MeshNeighbour& mesh : given) {
      first_node_.push_back(first);
      first += static_cast<int>(mesh.shells.points.rows());
    }
    given_nodes_ = first;
    join_loops(tolerance);
  }

  JoinedMesh joined(const std::vector<std::string>& names) {
    JoinedMesh result;
    result.new_loops = new_loops_;
    result.joined_loops = joined_loops_;
    result.open_edges = open_edges_;
    ShellMesh& mesh = result.mesh;
    std::vector<int> number(node_.size(), -1);
    std::vector<Vec3> more;
    std::vector<char> used(node_.size(), 0);
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (!removed_[t])
        for (const int v : triangles_[t]) used[v] = 1;
    for (size_t v = 0; v < node_.size(); ++v) {
      number[v] = node_[v];
      if (number[v] >= 0 || !used[v]) continue;
      number[v] = given_nodes_ + isize(more);
      more.push_back(added_.points.row(isize_of(v)).transpose());
    }
    mesh.points.resize(given_nodes_ + isize(more), 3);
    for (size_t g = 0; g < given_.size(); ++g) {
      mesh.points.middleRows(first_node_[g], given_[g].shells.points.rows()) =
          given_[g].shells.points;
      for (MeshSet set : given_[g].sets) {
        for (int& node : set.nodes) node += first_node_[g];
        for (int& face : set.faces) face += mesh.face_count();
        result.sets.push_back(std::move(set));
      }
      add_given(given_[g], first_node_[g], mesh);
    }
    for (int i = 0; i < isize(more); ++i) mesh.points.row(given_nodes_ + i) = more[i].transpose();
    const size_t first_new = result.sets.size();
    for (const std::string& name : names)
      result.sets.push_back({unused(name, result.sets), "", {}, {}});
    add_new(number, first_new, result);
    count_edges(result);
    return result;
  }

 private:
  // A name that no set has: `name`, or "name 2", "name 3" …
  static std::string unused(const std::string& name, const std::vector<MeshSet>& sets) {
    std::string free = name;
    const auto is_used = [&](const MeshSet& set) { return set.name == free; };
    for (int k = 2; std::any_of(sets.begin(), sets.end(), is_used); ++k)
      free = name + " " + std::to_string(k);
    return free;
  }

  static Eigen::Index isize_of(size_t v) { return static_cast<Eigen::Index>(v); }

  void join_loops(double tolerance) {
    const std::vector<std::vector<int>> loops = boundary_loops(edges_);
    new_loops_ = isize(loops);
    std::vector<char> used(loops.size(), 0);
    std::vector<char> reversed(triangles_.size(), 0);  // by component
    for (const MeshNeighbour& mesh : given_)
      for (const MeshBoundary& boundary : mesh.boundaries) open_edges_ += isize(boundary.vertices);
    for (size_t g = 0; g < given_.size(); ++g)
      for (const MeshBoundary& boundary : given_[g].boundaries) {
        GivenLoop polygon(given_[g].prepared.mesh, boundary, first_node_[g]);
        for (size_t l = 0; l < loops.size(); ++l) {
          if (used[l]) continue;
          std::vector<Vec3> points;
          for (const int v : loops[l]) points.push_back(added_.points.row(v).transpose());
          auto found = match(points, polygon, tolerance);
          if (!found) continue;
          used[l] = 1;
          // The given mesh lies to the left of its loop, so the loop of the new one is to run back.
          const size_t side = edges_.at({loops[l][0], loops[l][1]});
          if (!found->reversed) reversed[component_[side]] = 1;
          ++joined_loops_;
          open_edges_ -= isize(boundary.vertices);
          if (loops_of(component_[side], loops) == 1 && polygon.count() <= few_) {
            fill_polygon(polygon, component_[side], region_[side]);
            break;
          }
          const bool rough = zigzags(polygon, points);
          if (rough) {
            fill_notches(polygon, given_[g], first_node_[g], side);
            if (add_strip(loops[l], polygon, !found->reversed)) break;
            found = match(points, polygon, std::numeric_limits<double>::infinity());
          }
          if (found) join_loop(loops[l], *found, polygon);
          break;
        }
      }
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (reversed[component_[t]]) std::swap(triangles_[t][0], triangles_[t][1]);
  }

  int loops_of(int component, const std::vector<std::vector<int>>& loops) const {
    return static_cast<int>(
        std::count_if(loops.begin(), loops.end(), [&](const std::vector<int>& loop) {
          return component_[edges_.at({loop[0], loop[1]})] == component;
        }));
  }

  // Replaces a component of the new triangles by triangles of given vertices.
  void fill_polygon(GivenLoop& polygon, int component, int region) {
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (component_[t] == component) removed_[t] = 1;
    for (const Triangle& triangle : polygon.all_ears()) notches_.emplace_back(triangle, region);
  }

  // True if vertices of a given loop are far from the loop of new triangles.
  static bool zigzags(const GivenLoop& given, const std::vector<Vec3>& points) {
    constexpr double least = 0.1;  // of the edge length
    double farthest = 0;
    for (int i = 0; i < given.count(); ++i) {
      double distance = std::numeric_limits<double>::infinity();
      for (size_t k = 0; k < points.size(); ++k) {
        const Vec3 edge = points[(k + 1) % points.size()] - points[k];
        const double t =
            std::clamp((given.point(i) - points[k]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
        distance = std::min(distance, (points[k] + t * edge - given.point(i)).norm());
      }
      farthest = std::max(farthest, distance);
    }
    return farthest > least * given.mean_edge();
  }

  // Adds triangles in the narrow notches of a given loop, which becomes shorter. `like`: a new
  // triangle of the same face.
  void fill_notches(GivenLoop& polygon, const MeshNeighbour& given, int first_node, size_t like) {
    std::set<int> nodes;
    for (int i = 0; i < polygon.count(); ++i) nodes.insert(polygon.node(i) - first_node);
    std::set<DirectedEdge> edges;
    for (int f = 0; f < given.shells.face_count(); ++f) {
      const auto corners = given.shells.corners(f);
      for (size_t c = 0; c < corners.size(); ++c)
        if (nodes.count(corners[c]) && nodes.count(corners[(c + 1) % corners.size()]))
          edges.insert(
              std::minmax(first_node + corners[c], first_node + corners[(c + 1) % corners.size()]));
    }
    for (const Triangle& triangle : polygon.cut_notches(std::move(edges)))
      notches_.emplace_back(triangle, region_[like]);
  }

  // Replaces the new triangles close to a given loop by a strip of triangles between the given
  // vertices and the rest. Returns false, without a change, if the rest is not one surface with one
  // loop there. `reversed`: the triangles of this component will be reversed.
  bool add_strip(const std::vector<int>& loop, const GivenLoop& polygon, bool reversed) {
    std::vector<char> removed = removed_;
    if (!remove_close(loop, polygon, removed)) return false;
    const auto edges = directed_edges(triangles_, removed);
    std::vector<std::vector<int>> inner;
    for (std::vector<int>& one : boundary_loops(edges))
      if (!edges_at_boundary(one)) inner.push_back(std::move(one));
    constexpr size_t most = 100'000'000;
    if (inner.size() != 1 || inner[0].size() * polygon.points().size() > most) return false;
    std::vector<int>& vertices = inner[0];
    std::vector<size_t> beside;  // the new triangle at each edge
    for (size_t k = 0; k < vertices.size(); ++k)
      beside.push_back(edges.at({vertices[k], vertices[(k + 1) % vertices.size()]}));
    // The rest lies to the left of its loop, too; the strip needs the direction of the given loop.
    if (!reversed) {
      std::reverse(vertices.begin(), vertices.end());
      std::reverse(beside.begin(), beside.end() - 1);
    }
    const std::vector<Vec3>& one = polygon.points();
    std::vector<Vec3> two;
    for (const int v : vertices) two.push_back(added_.points.row(v).transpose());
    const auto first = std::min_element(two.begin(), two.end(), [&](const Vec3& a, const Vec3& b) {
      return (a - one[0]).squaredNorm() < (b - one[0]).squaredNorm();
    });
    removed_ = std::move(removed);
    const int last_node = isize(node_);
    for (int i = 0; i < polygon.count(); ++i) node_.push_back(polygon.node(i));
    const auto given = [&](int i) { return last_node + i % polygon.count(); };
    const auto rest = [&](int j) { return vertices[static_cast<size_t>(j) % vertices.size()]; };
    for (const auto& t :
         Strip(one, two, polygon.normals()).triangles(static_cast<int>(first - two.begin()))) {
      const int j = t.triangle_of == 0 ? t.j : t.i;
      Triangle corners = t.triangle_of == 0 ? Triangle{given(t.i + 1), given(t.i), rest(t.j)}
                                            : Triangle{rest(t.i), rest(t.i + 1), given(t.j)};
      if (reversed) std::swap(corners[0], corners[1]);
      add_like(beside[static_cast<size_t>(j) % beside.size()], corners);
    }
    return true;
  }

  // True if an edge of a loop is an edge of the boundary of all new triangles.
  bool edges_at_boundary(const std::vector<int>& loop) const {
    for (size_t k = 0; k < loop.size(); ++k)
      if (!edges_.count({loop[(k + 1) % loop.size()], loop[k]})) return true;
    return false;
  }

  // Flags the new triangles close to a given loop, and what they separate from the largest rest.
  // Returns false if nothing is left, or if another loop of the new triangles is as close.
  bool remove_close(const std::vector<int>& loop, const GivenLoop& polygon,
                    std::vector<char>& removed) const {
    constexpr double close = 0.7;  // of the mean edge length of the given loop
    std::map<int, std::vector<size_t>> around;
    for (const auto& [edge, t] : edges_) around[edge.first].push_back(t);
    std::set<int> visited(loop.begin(), loop.end());
    std::vector<int> queue(loop.begin(), loop.end());
    const auto remove_around = [&](int v) {
      for (const size_t t : around[v]) {
        removed[t] = 1;
        for (const int w : triangles_[t])
          if (visited.insert(w).second) queue.push_back(w);
      }
    };
    const std::set<int> own(loop.begin(), loop.end());
    while (!queue.empty()) {
      const int v = queue.back();
      queue.pop_back();
      const Vec3 x = added_.points.row(v).transpose();
      if (own.count(v) || polygon.is_close(x, close * polygon.mean_edge())) remove_around(v);
    }
    while (const auto pinch = pinched(removed)) remove_around(*pinch);
    keep_largest(component_[edges_.at({loop[0], loop[1]})], removed);
    if (pinched(removed)) return false;
    for (const auto& [edge, t] : edges_)
      if (removed[t] && !removed_[t] && !edges_.count({edge.second, edge.first}) &&
          !own.count(edge.first))
        return false;
    return true;
  }

  // A vertex with two boundary edges that leave it.
  std::optional<int> pinched(const std::vector<char>& removed) const {
    const auto edges = directed_edges(triangles_, removed);
    std::set<int> starts;
    for (const auto& [edge, t] : edges)
      if (!edges.count({edge.second, edge.first}) && !starts.insert(edge.first).second)
        return edge.first;
    return {};
  }

  // Removes all but the largest connected set of triangles of a component.
  void keep_largest(int component, std::vector<char>& removed) const {
    const auto edges = directed_edges(triangles_, removed);
    std::vector<char> visited = removed;
    std::vector<size_t> largest;
    std::vector<size_t> all;
    for (size_t seed = 0; seed < triangles_.size(); ++seed) {
      if (visited[seed] || component_[seed] != component) continue;
      visited[seed] = 1;
      std::vector<size_t> set{seed};
      for (size_t k = 0; k < set.size(); ++k)
        for (size_t c = 0; c < 3; ++c) {
          const Triangle& here = triangles_[set[k]];
          const auto next = edges.find({here[(c + 1) % 3], here[c]});
          if (next == edges.end() || visited[next->second]) continue;
          visited[next->second] = 1;
          set.push_back(next->second);
        }
      all.insert(all.end(), set.begin(), set.end());
      if (set.size() > largest.size()) largest = std::move(set);
    }
    for (const size_t t : all) removed[t] = 1;
    for (const size_t t : largest) removed[t] = 0;
  }

  // Splits the triangles at an edge with several given vertices, then assigns nodes.
  void join_loop(const std::vector<int>& loop, const LoopMatch& found, const GivenLoop& polygon) {
    const int count = polygon.count();
    const auto node_at = [&](int k) { return polygon.node((k % count) + count); };
    const int step = found.reversed ? -1 : 1;
    for (size_t i = 0; i < loop.size(); ++i) {
      const size_t j = (i + 1) % loop.size();
      const int from = found.given[i], to = found.given[j] + (j == 0 ? step * count : 0);
      std::vector<int> between;
      for (int k = from + step; k != to && from != to; k += step) {
        between.push_back(isize(node_));
        node_.push_back(node_at(k));
      }
      if (!between.empty()) split(loop[i], loop[j], between);
    }
    for (size_t i = 0; i < loop.size(); ++i) node_[loop[i]] = node_at(found.given[i]);
  }

  // Replaces the triangle at the boundary edge from a to b by a fan through the vertices `between`.
  void split(int a, int b, const std::vector<int>& between) {
    const size_t t = edges_.at({a, b});
    const Triangle whole = triangles_[t];
    int c = 0;
    for (const int v : whole)
      if (v != a && v != b) c = v;
    int before = a;
    for (const int v : between) {
      const size_t index = before == a ? t : triangles_.size();
      if (before == a)
        triangles_[t] = {a, v, c};
      else {
        add_like(t, {before, v, c});
      }
      edges_[{before, v}] = index;
      before = v;
    }
    add_like(t, {before, b, c});
    edges_[{before, b}] = edges_[{b, c}] = triangles_.size() - 1;
  }

  void add_like(size_t t, const Triangle& triangle) {
    triangles_.push_back(triangle);
    removed_.push_back(0);
    region_.push_back(region_[t]);
    component_.push_back(component_[t]);
  }

  void add_given(const MeshNeighbour& given, int first, ShellMesh& mesh) const {
    const std::vector<char> flipped = flipped_faces(given);
    for (int f = 0; f < given.shells.face_count(); ++f) {
      std::vector<int> nodes;
      for (const int node : given.shells.face(f)) nodes.push_back(first + node);
      if (flipped[f]) {
        const auto corners = isize(given.shells.corners(f));
        std::reverse(nodes.begin(), nodes.begin() + corners);
        // The midside node of the last edge stays the last one.
        if (given.shells.second_order(f)) std::reverse(nodes.begin() + corners, nodes.end() - 1);
      }
      mesh.add_face(nodes, given.shells.second_order(f));
    }
  }

  // Flags of the faces that prepare() has reversed.
  static std::vector<char> flipped_faces(const MeshNeighbour& given) {
    std::vector<char> flipped(static_cast<size_t>(given.shells.face_count()), 0);
    const PreparedMesh& prepared = given.prepared;
    for (int t = 0; t < prepared.mesh.triangle_count(); ++t) {
      const int f = prepared.face_of_triangle[t];
      const auto corners = given.shells.corners(f);
      for (size_t c = 0; c < 3; ++c)
        for (size_t k = 0; k < corners.size(); ++k) {
          const auto node = [&](size_t i) {
            return prepared.mesh.topology().node_of(prepared.mesh.triangles()[t][i % 3]);
          };
          if (node(c + 1) == corners[k] && node(c) == corners[(k + 1) % corners.size()])
            flipped[f] = 1;
        }
    }
    return flipped;
  }

  void add_new(const std::vector<int>& number, size_t first_new, JoinedMesh& result) const {
    for (size_t t = 0; t < triangles_.size(); ++t) {
      if (removed_[t]) continue;
      const Triangle nodes{number[triangles_[t][0]], number[triangles_[t][1]],
                           number[triangles_[t][2]]};
      if (nodes[0] == nodes[1] || nodes[1] == nodes[2] || nodes[2] == nodes[0]) continue;
      result.sets[first_new + static_cast<size_t>(region_[t])].faces.push_back(
          result.mesh.face_count());
      result.mesh.add_face(nodes);
    }
    for (const auto& [nodes, region] : notches_) {
      result.sets[first_new + static_cast<size_t>(region)].faces.push_back(
          result.mesh.face_count());
      result.mesh.add_face(nodes);
    }
  }

  // Counts free edges, and edges with more than two faces if one of these is new.
  void count_edges(JoinedMesh& result) const {
    int given = 0;
    for (const MeshNeighbour& mesh : given_) given += mesh.shells.face_count();
    std::map<DirectedEdge, std::pair<int, bool>> count;
    for (int f = 0; f < result.mesh.face_count(); ++f) {
      const auto corners = result.mesh.corners(f);
      for (size_t c = 0; c < corners.size(); ++c) {
        auto& [faces, has_new] = count[std::minmax(corners[c], corners[(c + 1) % corners.size()])];
        ++faces;
        has_new = has_new || f >= given;
      }
    }
    for (const auto& [edge, found] : count) {
      result.free_edges += found.first == 1;
      result.non_manifold_edges += found.first > 2 && found.second;
    }
  }

  const std::vector<MeshNeighbour>& given_;
  const WeldedMesh& added_;
  std::vector<Triangle> triangles_;
  std::vector<int> region_, component_;
  static constexpr int few_ = 4;  // vertices of loops that need no new ones
  std::vector<char> removed_;
  std::vector<std::pair<Triangle, int>> notches_;  // triangles of given nodes, and their faces
  std::vector<int> node_, first_node_;             // given node of each new vertex, or -1
  std::map<DirectedEdge, size_t> edges_;
  int given_nodes_ = 0, new_loops_ = 0, joined_loops_ = 0, open_edges_ = 0;
};

}  // namespace

JoinedMesh join_meshes(const std::vector<MeshNeighbour>& given, const WeldedMesh& added,
                       const std::vector<std::string>& names, double tolerance) {
  return MeshJoiner(given, added, tolerance).joined(names);
}

}  // namespace batten
