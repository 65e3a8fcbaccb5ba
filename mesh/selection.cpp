// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

// One flag for each of `count` items; throws InputError for indices out of range.
std::vector<char> flags(int count, const std::vector<int>& numbers, const char* what) {
  std::vector<char> result(count, 0);
  for (const int i : numbers) {
    if (i < 0 || i >= count)
      throw InputError(std::string("found ") + what + " " + std::to_string(i) + ", expected 0 to " +
                       std::to_string(count - 1));
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

// Vertices that have triangles and whose position satisfies a condition.
template <class Condition>
Selection vertices_where(const TriangleMesh& mesh, const Condition& condition) {
  Selection result;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.topology().component()[v] >= 0 && condition(mesh.point(v))) result.push_back(v);
  return result;
}

// Fast marching with virtual sources; see geodesic_distances().
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
    // A vertex may be reached earlier than one of the two corners between which the front passed.
    // So go on for one more edge length.
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
  // On well-shaped meshes vertices are processed once or twice. Where nearly all triangles are
  // obtuse, some would be processed thousands of times for the last digits.
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

  // Front that passes between a and b and reaches c, in the plane of the triangle:
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
  std::vector<char> source_, unfolded_;  // unfolded_: the front that reached the vertex started
                                         // from an edge
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
    throw InputError("the normal of the plane has length 0 or is not finite");
  const Vec3 n = normal / length;
  return vertices_where(mesh, [&](const Vec3& p) {
    const double height = n.dot(p - origin);
    return height >= 0 && height <= max_height;
  });
}

VecX geodesic_distances(const TriangleMesh& mesh, const std::vector<int>& sources,
                        double farthest) {
  if (sources.empty()) throw InputError("geodesic distances need at least one source, found none");
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
  if (nearest < 0) throw InputError("no vertex is close to the point: the mesh has no triangles");
  return nearest;
}

namespace {

constexpr double kEpsilon = 0.003;  // fraction of the box diagonal
constexpr int kScales = 5;          // number of scales, σ = 2ε … 6ε
// All widths that occur, in units of ε: 2 … 6 and their doubles.
constexpr std::array<int, 8> kWidths = {2, 3, 4, 5, 6, 8, 10, 12};
constexpr std::array<int, kScales> kNarrow = {0, 1, 2, 3, 4}, kWide = {2, 4, 5, 6, 7};

/// Uniform grid over the vertices of a mesh, for neighbourhood queries. Unlike a BoxTree it needs no
/// descent, as all queries have the same radius, and it visits cells in a fixed order.
class SpatialGrid {
 public:
  SpatialGrid(const Points& points, double size) : points_(points), size_(size) {
    low_ = points.colwise().minCoeff().transpose();
    high_ = points.colwise().maxCoeff().transpose();
    for (int d = 0; d < 3; ++d) count_[d] = static_cast<long>((high_[d] - low_[d]) / size) + 1;
    for (int v = 0; v < points.rows(); ++v) entries_.push_back({key(cell_of(v)), v});
    std::sort(entries_.begin(), entries_.end());
  }
  /// Calls visit(j, |p_j - p_i|²) for all vertices in the 27 cells around the cell of i.
  template <class Visit>
  void around(int i, const Visit& visit) const {
    const auto [x, y, z] = cell_of(i);
    for (long a = std::max(0L, x - 1); a <= std::min(count_[0] - 1, x + 1); ++a)
      for (long b = std::max(0L, y - 1); b <= std::min(count_[1] - 1, y + 1); ++b) {
        // Cells along z are contiguous.
        const long first = key({a, b, std::max(0L, z - 1)});
        const long last = key({a, b, std::min(count_[2] - 1, z + 1)});
        for (auto it = std::lower_bound(entries_.begin(), entries_.end(), std::pair(first, -1));
             it != entries_.end() && it->first <= last; ++it)
          visit(it->second, (points_.row(it->second) - points_.row(i)).squaredNorm());
      }
  }

 private:
  std::array<long, 3> cell_of(int v) const {
    std::array<long, 3> at;
    for (int d = 0; d < 3; ++d)
      at[d] = std::min(count_[d] - 1, static_cast<long>((points_(v, d) - low_[d]) / size_));
    return at;
  }
  long key(const std::array<long, 3>& c) const {
    return (c[0] * count_[1] + c[1]) * count_[2] + c[2];
  }
  const Points& points_;
  double size_;
  Vec3 low_, high_;
  std::array<long, 3> count_{};
  std::vector<std::pair<long, int>> entries_;  // cell key, vertex
};

/// Mean curvature δ_i · n_i of each vertex.
VecX mean_curvatures(const TriangleMesh& mesh, const VecX& area) {
  Points normal = Points::Zero(mesh.vertex_count(), 3);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles()[t]) normal.row(v) += mesh.area_vector(t).transpose();
  const SparseMatrix L = cotangent_laplacian(mesh);
  const Points relative = mesh.points().rowwise() - mesh.box().center().transpose();
  const Points Lp = L.selfadjointView<Eigen::Lower>() * relative;
  VecX C = VecX::Zero(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (const double length = normal.row(v).norm(); length > 0 && area[v] > 0)
      C[v] = Lp.row(v).dot(normal.row(v)) / (length * 2 * area[v]);
  return C;
}

/// Local maxima of a map below this value, relative to the global one, are rounding errors of flat
/// regions.
constexpr double kSmallestPeak = 1e-6;

/// Itti's weight (1 - m̄)² of a map whose maximum is 1: m̄ is the mean of its other local maxima.
double normalization_weight(const TriangleMesh& mesh, const VecX& map) {
  int highest = -1;
  double sum = 0;
  int count = 0;
  for (int v = 0; v < map.size(); ++v) {
    const auto ring = mesh.topology().neighbours(v);
    const bool peak = !ring.empty() && std::all_of(ring.begin(), ring.end(), [&](int u) {
      return map[v] > map[u] || (map[v] == map[u] && v < u);
    });
    if (!peak || !(map[v] > kSmallestPeak)) continue;
    sum += map[v];
    ++count;
    if (highest < 0 || map[v] > map[highest]) highest = v;
  }
  if (count < 2) return 1;
  const double others = (sum - map[highest]) / (count - 1);
  return (1 - others) * (1 - others);
}

}  // namespace

VecX mesh_saliency(const TriangleMesh& mesh) {
  if (mesh.triangle_count() == 0) throw InputError("a mesh without triangles has no saliency");
  const int n = mesh.vertex_count();
  const double epsilon = kEpsilon * mesh.size();
  const VecX area = mixed_areas(mesh), C = mean_curvatures(mesh, area);
  const SpatialGrid grid(mesh.points(), 2 * kWidths.back() * epsilon);
  MatX maps = MatX::Zero(n, kScales);
  parallel_for_each<256>(n, [&](int i) {
    if (!(area[i] > 0)) return;
    std::array<double, kWidths.size()> sum{}, weight{};
    grid.around(i, [&](int j, double square) {
      for (size_t w = 0; w < kWidths.size(); ++w) {
        const double sigma = kWidths[w] * epsilon;
        if (square > 4 * sigma * sigma) continue;
        const double g = area[j] * std::exp(-square / (2 * sigma * sigma));
        weight[w] += g;
        sum[w] += g * C[j];
      }
    });
    for (int s = 0; s < kScales; ++s)
      maps(i, s) =
          std::abs(sum[kNarrow[s]] / weight[kNarrow[s]] - sum[kWide[s]] / weight[kWide[s]]);
  });
  VecX saliency = VecX::Zero(n);
  for (int s = 0; s < kScales; ++s) {
    const double most = maps.col(s).maxCoeff();
    if (!(most > 1e-9 / mesh.size())) continue;
    const VecX map = maps.col(s) / most;
    saliency += normalization_weight(mesh, map) * map;
  }
  if (const double most = saliency.maxCoeff(); most > 0) saliency /= most;
  return saliency;
}

std::vector<int> grown_region(const TriangleMesh& mesh, const VecX& saliency, int picked,
                              double threshold) {
  if (saliency.size() != mesh.vertex_count())
    throw InputError("found " + std::to_string(saliency.size()) + " saliency values, expected " +
                     std::to_string(mesh.vertex_count()));
  if (picked < 0 || picked >= mesh.vertex_count())
    throw InputError("found the picked vertex " + std::to_string(picked) + ", expected 0 to " +
                     std::to_string(mesh.vertex_count() - 1));
  if (!(saliency[picked] >= threshold))
    throw InputError("the picked vertex " + std::to_string(picked) + " has saliency " +
                     format_number(saliency[picked]) + ", expected the threshold " +
                     format_number(threshold) + " or more");
  std::vector<char> seen(mesh.vertex_count(), 0);
  std::vector<int> region = {picked};
  seen[picked] = 1;
  for (size_t k = 0; k < region.size(); ++k)
    for (const int v : mesh.topology().neighbours(region[k]))
      if (!seen[v] && saliency[v] >= threshold) {
        seen[v] = 1;
        region.push_back(v);
      }
  std::sort(region.begin(), region.end());
  return region;
}

}  // namespace batten
