#include "batten/mesh/aabb_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace batten {
namespace {

/// Barycentric coordinates of the nearest point of a triangle. Source: Ericson 2005, 5.1.5.
Vec3 nearest_in_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

constexpr int kLeafSize = 4;  // triangles
constexpr int kDeepest = 64;  // halves of more triangles than there can be

}  // namespace

AabbTree::AabbTree(const TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangle_count()) {
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> centroids;
  for (const auto& [a, b, c] : mesh.triangles())
    centroids.push_back((mesh.point(a) + mesh.point(b) + mesh.point(c)) / 3);
  if (!order_.empty()) build(0, isize(order_), centroids);
}

int AabbTree::build(int first, int last, const std::vector<Vec3>& centroids) {
  Node node;
  node.first = first;
  node.last = last;
  node.low.setConstant(std::numeric_limits<double>::infinity());
  node.high = -node.low;
  for (int i = first; i < last; ++i)
    for (const int v : mesh_.triangles()[order_[i]]) {
      node.low = node.low.cwiseMin(mesh_.point(v));
      node.high = node.high.cwiseMax(mesh_.point(v));
    }
  const int own = isize(nodes_);
  nodes_.push_back(node);
  if (last - first <= kLeafSize) return own;
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const int middle = (first + last) / 2;
  const auto before = [&](int s, int t) {
    return centroids[s][axis] != centroids[t][axis] ? centroids[s][axis] < centroids[t][axis]
                                                    : s < t;
  };
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, before);
  build(first, middle, centroids);
  const int right = build(middle, last, centroids);
  nodes_[own].right = right;
  return own;
}

std::optional<AabbTree::ClosestPoint> AabbTree::nearest(const Vec3& p,
                                                        const std::optional<Vec3>& normal) const {
  if (nodes_.empty()) return {};
  ClosestPoint best;
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&](int t) {
    if (normal && mesh_.area_vector(t).dot(*normal) <= 0) return;
    const auto& [a, b, c] = mesh_.triangles()[t];
    const Vec3 w = nearest_in_triangle(p, mesh_.point(a), mesh_.point(b), mesh_.point(c));
    const Vec3 q = w[0] * mesh_.point(a) + w[1] * mesh_.point(b) + w[2] * mesh_.point(c);
    const double distance2 = (q - p).squaredNorm();
    // One without area may have no nearest point.
    if (!(distance2 < least || (distance2 == least && t < best.triangle))) return;
    least = distance2;
    best = {t, q, w, 0};
  };
  // The nearer half first; what is farther than the best point is passed over when its turn comes.
  std::array<std::pair<double, int>, kDeepest> later;
  size_t count = 0;
  later[count++] = {nodes_[0].distance2(p), 0};
  while (count > 0) {
    const auto [distance2, n] = later[--count];
    if (distance2 > least) continue;
    const Node& node = nodes_[n];
    if (node.right < 0) {
      for (int i = node.first; i < node.last; ++i) look_at(order_[i]);
      continue;
    }
    const std::pair<double, int> left{nodes_[n + 1].distance2(p), n + 1},
        right{nodes_[node.right].distance2(p), node.right};
    const bool left_first = left.first <= right.first;
    later[count++] = left_first ? right : left;
    later[count++] = left_first ? left : right;
  }
  if (best.triangle < 0) return {};
  best.distance = std::sqrt(least);
  return best;
}

}  // namespace batten
