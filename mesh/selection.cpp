#include "batten/mesh/selection.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <string>

#include "batten/core/disjoint_sets.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// One flag for each of `count` things; refuses numbers out of range.
std::vector<char> flags(int count, const std::vector<int>& numbers, const char* what) {
  std::vector<char> result(count, 0);
  for (const int i : numbers) {
    if (i < 0 || i >= count)
      throw InputError(std::string(what) + " " + std::to_string(i) + " does not exist: there are " +
                       std::to_string(count));
    result[i] = 1;
  }
  return result;
}

std::vector<char> vertex_flags(const MeshTopology& topology, const std::vector<int>& vertices) {
  return flags(topology.vertex_count(), vertices, "vertex");
}

std::vector<int> indices_of(const std::vector<char>& flags) {
  std::vector<int> result;
  for (size_t i = 0; i < flags.size(); ++i)
    if (flags[i]) result.push_back(static_cast<int>(i));
  return result;
}

// Vertices that have triangles and whose place satisfies a condition.
template <class Condition>
Selection vertices_where(const TriangleMesh& mesh, const Condition& condition) {
  Selection result;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.topology().component()[v] >= 0 && condition(mesh.point(v))) result.push_back(v);
  return result;
}

// Distances along the surface by fronts through triangles.
class FastMarching {
 public:
  FastMarching(const TriangleMesh& mesh, const std::vector<int>& sources, double farthest)
      : mesh_(mesh),
        source_(vertex_flags(mesh.topology(), sources)),
        unfolded_(mesh.vertex_count(), 0),
        taken_(mesh.vertex_count(), 0),
        distance_(VecX::Constant(mesh.vertex_count(), kInfinity)) {
    for (const int source : sources)
      for (const int v : mesh.topology().coincident_vertices(source)) {
        source_[v] = 1;
        distance_[v] = 0;
        queue_.push({0, v});
      }
    // A front may reach a vertex sooner than one of the corners that it passed between.
    double longest = 0;
    if (std::isfinite(farthest))
      for (const auto& e : mesh.topology().edges())
        longest = std::max(longest, (mesh.point(e.low) - mesh.point(e.high)).norm());
    while (!queue_.empty()) {
      const auto [d, v] = queue_.top();
      queue_.pop();
      if (d > farthest + longest) break;
      if (d == distance_[v] && ++taken_[v] <= kMostTimes) pass_on(v);
    }
    for (double& d : distance_)
      if (d > farthest) d = kInfinity;
  }

  VecX take() { return std::move(distance_); }

 private:
  // Vertices are taken once or twice where triangles are sound; where nearly all are obtuse, some
  // would be taken thousands of times for the last digits.
  static constexpr int kMostTimes = 20;

  void pass_on(int v) {
    for (const int t : mesh_.topology().triangles_of(v)) {
      const auto& corners = mesh_.triangles()[t];
      const auto i = std::find(corners.begin(), corners.end(), v) - corners.begin();
      const int a = corners[(i + 1) % 3], b = corners[(i + 2) % 3];
      if (std::isfinite(distance_[a])) origin(v, a, b);
      if (std::isfinite(distance_[b])) origin(v, b, a);
    }
    for (const int j : mesh_.topology().neighbours(v))
      offer(j, distance_[v] + (mesh_.point(j) - mesh_.point(v)).norm(), unfolded_[v]);
    for (const int j : mesh_.topology().coincident_vertices(v))
      offer(j, distance_[v], unfolded_[v]);
  }

  void offer(int v, double d, bool straight) {
    if (!(d < distance_[v] * (1 - 1e-13))) return;
    distance_[v] = d;
    unfolded_[v] = straight;
    queue_.push({d, v});
  }

  // The front that passes between a and b and then reaches c, in the plane of the triangle:
  // a = (0, 0), b = (length, 0), c above.
  void origin(int a, int b, int c) {
    const Vec3 ab = mesh_.point(b) - mesh_.point(a), ac = mesh_.point(c) - mesh_.point(a);
    const double length = ab.norm(), d_a = distance_[a], d_b = distance_[b];
    const double x = ac.dot(ab) / length, y = ac.cross(ab).norm() / length;
    if (!(y > 0)) return;
    constexpr double slack = 1e-12;
    if (unfolded_[a] || unfolded_[b] || (source_[a] && source_[b])) {
      const double g = (d_b - d_a) / length;
      if (!(std::abs(g) < 1)) return;
      const double h = std::sqrt((1 - g) * (1 + g)), crossing = x - g / h * y;
      if (crossing < -slack * length || crossing > (1 + slack) * length) return;
      offer(c, d_a + g * x + h * y, true);
    } else {
      const double s = 0.5 * (length + (d_a - d_b) * (d_a + d_b) / length);
      const double below = (d_a - s) * (d_a + s);
      if (!(below >= 0)) return;
      const double depth = std::sqrt(below), crossing = s + (x - s) * depth / (depth + y);
      if (crossing < -slack * length || crossing > (1 + slack) * length) return;
      offer(c, std::hypot(x - s, y + depth), false);
    }
  }

  using Entry = std::pair<double, int>;
  const TriangleMesh& mesh_;
  std::vector<char> source_, unfolded_;  // straight: the front here started from an edge
  std::vector<int> taken_;
  VecX distance_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

Selection vertices_in_box(const TriangleMesh& mesh, const Vec3& low, const Vec3& high) {
  return vertices_where(mesh, [&](const Vec3& p) {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  });
}

Selection vertices_in_sphere(const TriangleMesh& mesh, const Vec3& centre, double radius) {
  return vertices_where(mesh, [&](const Vec3& p) { return (p - centre).norm() <= radius; });
}

Selection vertices_beyond_plane(const TriangleMesh& mesh, const Vec3& origin, const Vec3& normal,
                                double max_height) {
  const double length = normal.norm();
  if (!(length > 0) || !std::isfinite(length))
    throw InputError("the normal of a plane has no direction");
  const Vec3 n = normal / length;
  return vertices_where(mesh, [&](const Vec3& p) {
    const double height = n.dot(p - origin);
    return height >= 0 && height <= max_height;
  });
}

VecX geodesic_distances(const TriangleMesh& mesh, const std::vector<int>& sources,
                        double farthest) {
  if (sources.empty()) throw InputError("distances along the surface need at least one source");
  return FastMarching(mesh, sources, farthest).take();
}

Selection vertices_within(const TriangleMesh& mesh, const std::vector<int>& sources,
                          double distance) {
  const VecX distances = geodesic_distances(mesh, sources, distance);
  Selection result;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (distances[v] <= distance) result.push_back(v);
  return result;
}

Selection grown(const MeshTopology& topology, const std::vector<int>& vertices, int rings) {
  std::vector<char> inside = vertex_flags(topology, vertices);
  inside = vertex_flags(topology, topology.expand_to_nodes(indices_of(inside)));
  std::vector<int> front = indices_of(inside), next;
  for (int ring = 0; ring < rings; ++ring) {
    next.clear();
    for (const int v : front)
      for (const int u : topology.neighbours(v))
        for (const int j : topology.coincident_vertices(u))
          if (!inside[j]) {
            inside[j] = 1;
            next.push_back(j);
          }
    front.swap(next);
  }
  return indices_of(inside);
}

Selection border(const MeshTopology& topology, const std::vector<int>& vertices) {
  const std::vector<char> inside = vertex_flags(topology, vertices);
  Selection result;
  for (const int v : indices_of(inside)) {
    const auto around = topology.neighbours(v);
    if (std::any_of(around.begin(), around.end(), [&](int j) { return !inside[j]; }))
      result.push_back(v);
  }
  return result;
}

Selection vertices_of_triangles(const MeshTopology& topology, const std::vector<int>& triangles) {
  std::vector<char> found(topology.vertex_count(), 0);
  for (const int t : indices_of(flags(topology.triangle_count(), triangles, "triangle")))
    for (const int v : topology.triangles()[t]) found[v] = 1;
  return indices_of(found);
}

std::vector<int> triangles_touching(const MeshTopology& topology,
                                    const std::vector<int>& vertices) {
  std::vector<char> found(topology.triangle_count(), 0);
  for (const int v : indices_of(vertex_flags(topology, vertices)))
    for (const int t : topology.triangles_of(v)) found[t] = 1;
  return indices_of(found);
}

Selection union_of(const Selection& a, const Selection& b) {
  Selection result;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

Selection intersection_of(const Selection& a, const Selection& b) {
  Selection result;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

Selection difference_of(const Selection& a, const Selection& b) {
  Selection result;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(result));
  return result;
}

std::vector<int> node_components(const MeshTopology& topology) {
  DisjointSets groups(topology.node_count());
  for (const auto& e : topology.edges())
    groups.unite(topology.node_of(e.low), topology.node_of(e.high));
  std::vector<int> part(topology.node_count(), -1);
  int count = 0;
  for (int v = 0; v < topology.node_count(); ++v) {
    if (topology.neighbours(v).empty()) continue;
    const int lowest = groups.find(v);
    part[v] = lowest == v ? count++ : part[lowest];
  }
  return part;
}

int nearest_vertex(const TriangleMesh& mesh, const Vec3& point) {
  int nearest = -1;
  double least = kInfinity;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double d = (mesh.point(v) - point).squaredNorm();
    if (mesh.topology().component()[v] >= 0 && d < least) {
      least = d;
      nearest = v;
    }
  }
  if (nearest < 0) throw InputError("no vertex is near the point: the mesh has no triangles");
  return nearest;
}

}  // namespace batten
