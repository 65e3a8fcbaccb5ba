#include "batten/mesh/regions/mesh_saliency.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

constexpr double kEpsilon = 0.003;  // of the box diagonal
constexpr int kScales = 5;          // σ = 2ε … 6ε
// All widths that are needed, in ε: 2 … 6 and their doubles.
constexpr std::array<int, 8> kWidths = {2, 3, 4, 5, 6, 8, 10, 12};
constexpr std::array<int, kScales> kNarrow = {0, 1, 2, 3, 4}, kWide = {2, 4, 5, 6, 7};

/// The vertices of a mesh in cubes of one size.
class SpatialGrid {
 public:
  SpatialGrid(const Points& points, double size) : points_(points), size_(size) {
    low_ = points.colwise().minCoeff().transpose();
    high_ = points.colwise().maxCoeff().transpose();
    for (int d = 0; d < 3; ++d) count_[d] = static_cast<long>((high_[d] - low_[d]) / size) + 1;
    for (int v = 0; v < points.rows(); ++v) entries_.push_back({key(cell_of(v)), v});
    std::sort(entries_.begin(), entries_.end());
  }
  /// Calls visit(j, |p_j - p_i|²) for all vertices in the cubes around that of i.
  template <class Visit>
  void around(int i, const Visit& visit) const {
    const auto [x, y, z] = cell_of(i);
    for (long a = std::max(0L, x - 1); a <= std::min(count_[0] - 1, x + 1); ++a)
      for (long b = std::max(0L, y - 1); b <= std::min(count_[1] - 1, y + 1); ++b) {
        // Cubes along z follow each other.
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
  std::vector<std::pair<long, int>> entries_;  // cube, vertex
};

/// δ_i · n_i.
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

/// (1 - m̄)², m̄ the mean of the local maxima of a map whose maximum is 1, without that one.
double normalization_weight(const TriangleMesh& mesh, const VecX& map) {
  int highest = -1;
  double sum = 0;
  int count = 0;
  for (int v = 0; v < map.size(); ++v) {
    const auto ring = mesh.topology().neighbours(v);
    const bool peak = !ring.empty() && std::all_of(ring.begin(), ring.end(), [&](int u) {
      return map[v] > map[u] || (map[v] == map[u] && v < u);
    });
    if (!peak || !(map[v] > 0)) continue;
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
    throw InputError("there are " + std::to_string(saliency.size()) + " saliencies, expected " +
                     std::to_string(mesh.vertex_count()));
  if (picked < 0 || picked >= mesh.vertex_count())
    throw InputError("picked vertex " + std::to_string(picked) + " of " +
                     std::to_string(mesh.vertex_count()));
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
