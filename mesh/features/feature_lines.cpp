// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/features/feature_lines.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void check_angle(double degrees, const char* what) {
  if (!(degrees > 0) || !(degrees < 180))
    throw InputError(std::string("found ") + what + " of " + format_number(degrees) +
                     " degrees, expected more than 0 and less than 180");
}

double cosine(double degrees) { return std::cos(degrees * std::numbers::pi / 180); }

class LineFinder {
 public:
  LineFinder(const TriangleMesh& mesh, const FeatureLineOptions& options)
      : mesh_(mesh), options_(options), edges_(mesh.topology().edges()) {
    check_angle(options.crease_degrees, "a crease angle");
    check_angle(options.corner_degrees, "a corner angle");
    at_.resize(mesh.topology().vertex_count());
    find_edges();
  }

  FeatureLines find() {
    FeatureLines result;
    result.lines = lines();
    line_of_.assign(edges_.size(), -1);
    for (int l = 0; l < isize(result.lines); ++l)
      for (const int e : result.lines[l].edges) line_of_[e] = l;
    result.patches = patches();
    return result;
  }

 private:
  using Kind = FeatureLine::Kind;

  void find_edges() {
    kinds_.assign(edges_.size(), std::nullopt);
    for (const int e : options_.given_edges) {
      if (e < 0 || e >= isize(edges_))
        throw InputError("found edge " + std::to_string(e) + ", expected 0 to " +
                         std::to_string(isize(edges_) - 1));
      kinds_[e] = Kind::Given;
    }
    const double crease = cosine(options_.crease_degrees);
    used_.assign(edges_.size(), 1);
    for (int e = 0; e < isize(edges_); ++e) {
      const auto& edge = edges_[e];
      if (is_boundary(edge))
        kinds_[e] = Kind::Boundary;
      else if (!(normal(edge.left).dot(normal(edge.right)) >= crease))
        kinds_[e] = Kind::Crease;
      if (!kinds_[e]) continue;
      used_[e] = 0;
      at_[edge.low].push_back(e);
      at_[edge.high].push_back(e);
    }
  }

  std::vector<FeatureLine> lines() {
    std::vector<FeatureLine> lines;
    for (int v = 0; v < isize(at_); ++v)
      if (!at_[v].empty() && ends_at(v))
        for (const int e : at_[v])
          if (!used_[e]) lines.push_back(along(v, e));
    for (int e = 0; e < isize(edges_); ++e)  // closed lines without a corner
      if (!used_[e]) {
        lines.push_back(along(edges_[e].low, e));
        lines.back().closed = true;
        lines.back().vertices.pop_back();
      }
    std::erase_if(lines, [&](const FeatureLine& line) { return is_noise(line); });
    return lines;
  }

  static bool is_boundary(const MeshTopology::Edge& edge) {
    return edge.left < 0 || edge.right < 0;
  }
  Vec3 normal(int triangle) const { return mesh_.area_vector(triangle).normalized(); }
  int other(int e, int v) const { return edges_[e].low == v ? edges_[e].high : edges_[e].low; }

  /// True if lines end at this vertex: it has not two feature edges, joins edges of different kinds,
  /// or is a corner.
  bool ends_at(int v) const {
    if (at_[v].size() != 2) return true;
    const int a = at_[v][0], b = at_[v][1];
    if (kinds_[a] != kinds_[b]) return true;
    const Vec3 in = (mesh_.point(v) - mesh_.point(other(a, v))).normalized(),
               out = (mesh_.point(other(b, v)) - mesh_.point(v)).normalized();
    return in.dot(out) < cosine(options_.corner_degrees);
  }

  FeatureLine along(int v, int e) {
    FeatureLine line;
    line.kind = *kinds_[e];
    line.vertices = {v};
    for (;;) {
      used_[e] = 1;
      line.edges.push_back(e);
      v = other(e, v);
      line.vertices.push_back(v);
      if (v == line.vertices.front() || ends_at(v)) break;
      e = at_[v][0] == e ? at_[v][1] : at_[v][0];
      if (used_[e]) break;
    }
    return line;
  }

  bool is_noise(const FeatureLine& line) const {
    if (line.kind != Kind::Crease || line.closed) return false;
    if (at_[line.vertices.front()].size() > 1 && at_[line.vertices.back()].size() > 1) return false;
    double length = 0;
    for (size_t i = 1; i < line.vertices.size(); ++i)
      length += (mesh_.point(line.vertices[i]) - mesh_.point(line.vertices[i - 1])).norm();
    return length < options_.min_length * mesh_.size();
  }

  /// Finds the sets of triangles that are connected without crossing a line.
  std::vector<FeaturePatch> patches() {
    const MeshTopology& topology = mesh_.topology();
    patch_of_.assign(topology.triangle_count(), -1);
    std::vector<FeaturePatch> result;
    for (int first = 0; first < topology.triangle_count(); ++first) {
      if (patch_of_[first] >= 0) continue;
      FeaturePatch patch;
      patch.triangles = {first};
      patch_of_[first] = isize(result);
      for (size_t i = 0; i < patch.triangles.size(); ++i)
        for (const int e : topology.edges_of(patch.triangles[i])) {
          const int t = across(e, patch.triangles[i]);
          if (line_of_[e] >= 0 || t < 0 || patch_of_[t] >= 0) continue;
          patch_of_[t] = isize(result);
          patch.triangles.push_back(t);
        }
      std::sort(patch.triangles.begin(), patch.triangles.end());
      patch.flat = is_flat(patch);
      result.push_back(std::move(patch));
    }
    for (int p = 0; p < isize(result); ++p) find_loops(result[p], p);
    return result;
  }

  int across(int e, int t) const { return edges_[e].left == t ? edges_[e].right : edges_[e].left; }

  bool is_flat(const FeaturePatch& patch) const {
    constexpr double straight = 1e-6;
    const Vec3 n = normal(patch.triangles.front());
    return std::all_of(patch.triangles.begin(), patch.triangles.end(),
                       [&](int t) { return (normal(t) - n).norm() < straight; });
  }

  /// Follows the border of a patch with the patch on its left.
  void find_loops(FeaturePatch& patch, int own) {
    std::map<int, std::vector<std::pair<int, int>>> from;  // vertex → (end vertex, edge)
    for (const int t : patch.triangles)
      for (int i = 0; i < 3; ++i) {
        const int e = mesh_.topology().edges_of(t)[i];
        if (line_of_[e] < 0) continue;
        const int t2 = across(e, t);
        if (t2 >= 0 && patch_of_[t2] == own) {
          patch.inner.push_back(line_of_[e]);
          continue;
        }
        const auto& corners = mesh_.triangles()[t];
        from[corners[(i + 1) % 3]].emplace_back(corners[(i + 2) % 3], e);
      }
    patch.inner = sorted_unique(std::move(patch.inner));
    std::vector<std::pair<double, std::vector<int>>> loops;
    for (auto& [start, ways] : from)
      while (!ways.empty()) {
        double length = 0;
        std::vector<int> loop;
        for (int v = start; !from[v].empty();) {
          const auto [next, e] = from[v].back();
          from[v].pop_back();
          length += (mesh_.point(next) - mesh_.point(v)).norm();
          if (loop.empty() || loop.back() != line_of_[e]) loop.push_back(line_of_[e]);
          v = next;
        }
        if (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
        loops.emplace_back(-length, std::move(loop));
      }
    std::stable_sort(loops.begin(), loops.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [length, loop] : loops) patch.loops.push_back(std::move(loop));
  }

  const TriangleMesh& mesh_;
  const FeatureLineOptions& options_;
  const std::vector<MeshTopology::Edge>& edges_;
  std::vector<std::vector<int>> at_;        // feature edges at each vertex
  std::vector<std::optional<Kind>> kinds_;  // per edge; none: not a feature edge
  std::vector<char> used_;
  std::vector<int> line_of_, patch_of_;  // per edge, per triangle; -1: none
};

}  // namespace

FeatureLines feature_lines(const TriangleMesh& mesh, const FeatureLineOptions& options) {
  return LineFinder(mesh, options).find();
}

namespace {

/// The length of an edge with dihedral angle a is divided by 1 + (a / 10 degrees)².
double crease_length(const TriangleMesh& mesh, int v, int u) {
  const auto& edges = mesh.topology().edges();
  const auto e = std::lower_bound(
      edges.begin(), edges.end(), std::pair(std::min(v, u), std::max(v, u)),
      [](const auto& edge, const auto& ends) { return std::pair(edge.low, edge.high) < ends; });
  const double length = (mesh.point(u) - mesh.point(v)).norm();
  if (e->left < 0 || e->right < 0) return length;
  const Vec3 a = mesh.area_vector(e->left), b = mesh.area_vector(e->right);
  const double degrees = std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
  return length / (1 + degrees * degrees / 100);
}

/// Appends the shortest path from one vertex to another, without the first vertex. Dijkstra's
/// algorithm from the goal, so that the path is obtained in forward order.
void append_shortest_path(const TriangleMesh& mesh, int from, int goal, std::vector<int>& path) {
  const MeshTopology& topology = mesh.topology();
  std::vector<double> distance(mesh.vertex_count(), std::numeric_limits<double>::infinity());
  std::vector<int> next(mesh.vertex_count(), -1);
  std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>>
      queue;
  distance[goal] = 0;
  queue.emplace(0, goal);
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    if (v == from) break;
    const auto offer = [&](int u, double longer) {
      if (!(longer < distance[u])) return;
      distance[u] = longer;
      next[u] = v;
      queue.emplace(longer, u);
    };
    for (const int u : topology.neighbours(v)) offer(u, d + crease_length(mesh, v, u));
    for (const int u : topology.coincident_vertices(v)) offer(u, d);
  }
  if (!std::isfinite(distance[from]))
    throw InputError(
        "found a path between parts of the mesh that are not connected, expected one "
        "part");
  for (int v = from; v != goal; v = next[v]) path.push_back(next[v]);
}

}  // namespace

std::vector<int> crease_path(const TriangleMesh& mesh, std::vector<int> through, bool closed) {
  if (through.empty()) throw InputError("found a path through no vertices, expected one or more");
  for (const int v : through)
    if (v < 0 || v >= mesh.vertex_count())
      throw InputError("found vertex " + std::to_string(v) + ", expected one of 0 to " +
                       std::to_string(mesh.vertex_count() - 1));
  if (closed) through.push_back(through.front());
  std::vector<int> path = {through.front()};
  for (size_t s = 0; s + 1 < through.size(); ++s)
    append_shortest_path(mesh, through[s], through[s + 1], path);
  // Manifold patches that meet at a node have separate vertices there.
  for (int& v : path) v = mesh.topology().node_of(v);
  path.erase(std::unique(path.begin(), path.end()), path.end());
  if (closed && path.size() > 1) path.pop_back();
  return path;
}

}  // namespace batten
