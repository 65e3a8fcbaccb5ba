#include "batten/mesh/deform/similarity.h"
#include "batten/core/dense.h"

#include <cmath>
#include <optional>

namespace batten {
namespace {

Similarity fit(const Points& before, const Points& after, const std::vector<int>& vertices,
               std::optional<double> scale, const std::vector<double>& weights = {}) {
  Similarity best;
  if (vertices.empty()) return best;
  const auto weight = [&](size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  // Sums relative to the first vertex: far from the origin they would lose digits.
  const Vec3 from = before.row(vertices[0]), to = after.row(vertices[0]);
  double total = 0;
  for (size_t i = 0; i < vertices.size(); ++i) total += weight(i);
  Vec3 mean_before = Vec3::Zero(), mean_after = Vec3::Zero(), low = Vec3::Zero(), high = low;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int v = vertices[i];
    const Vec3 x = before.row(v).transpose() - from;
    mean_before += weight(i) / total * x;
    mean_after += weight(i) / total * (after.row(v).transpose() - to);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  Mat3 covariance = Mat3::Zero();
  double spread = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const int v = vertices[i];
    const Vec3 x = before.row(v).transpose() - from - mean_before;
    covariance += weight(i) * (after.row(v).transpose() - to - mean_after) * x.transpose();
    spread += weight(i) * x.squaredNorm();
  }
  const auto [U, values, V] = svd(covariance);
  Vec3 sign = Vec3::Ones();
  if ((U * V.transpose()).determinant() < 0) sign[2] = -1;
  best.R = U * sign.asDiagonal() * V.transpose();
  // Points on one line: of all rotations that fit the smallest.
  if (values[1] <= 1e-12 * values[0])
    best.R = Eigen::Quaterniond::FromTwoVectors(V.col(0), U.col(0)).matrix();
  best.scale = scale ? *scale : spread > 0 ? values.dot(sign) / spread : 1;
  for (const int v : vertices) {
    const Vec3 x = before.row(v).transpose() - from - mean_before;
    const double off =
        (after.row(v).transpose() - to - mean_after - best.scale * (best.R * x)).norm();
    if (!std::isnan(best.max_error) && !(off <= best.max_error)) best.max_error = off;
  }
  const double size = (high - low).norm();
  if (size > 0) best.max_error /= size;
  best.translation = to + mean_after - best.scale * (best.R * (from + mean_before));
  return best;
}

}  // namespace

Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices) {
  return fit(before, after, vertices, {});
}

Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale) {
  return fit(before, after, vertices, scale);
}

Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale,
                          const std::vector<double>& weights) {
  return fit(before, after, vertices, scale, weights);
}

}  // namespace batten
