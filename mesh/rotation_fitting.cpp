// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/rotation_fitting.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/simd.h"

namespace batten {
namespace {

Mat3 cofactors(const Mat3& M) {
  Mat3 c;
  c.col(0) = M.col(1).cross(M.col(2));
  c.col(1) = M.col(2).cross(M.col(0));
  c.col(2) = M.col(0).cross(M.col(1));
  return c;
}

Mat3 rotation_by_svd(const Mat3& M) {
  const double size = M.cwiseAbs().maxCoeff();
  if (!(size > 0) || !std::isfinite(size)) return Mat3::Identity();
  const auto [P, values, Q] = svd(Mat3(M / size));
  if (values[1] <= 1e-12 * values[0])
    return Eigen::Quaterniond::FromTwoVectors(Q.col(0), P.col(0)).normalized().matrix();
  Vec3 sign = Vec3::Ones();
  if (P.determinant() * Q.determinant() < 0) sign[2] = -1;
  return P * sign.asDiagonal() * Q.transpose();
}

}  // namespace

Mat3 nearest_rotation(const Mat3& M) {
  const double size = M.norm();
  if (!(size > 0) || !std::isfinite(size)) return Mat3::Identity();
  const Mat3 unit = M / size;
  const Mat3 c = cofactors(unit);
  const double det = unit.col(0).dot(c.col(0)), flat = c.norm();
  if (det < -1e-10 || flat < 1e-4) return rotation_by_svd(M);
  // The cofactor matrix has the same singular vectors. Its singular values are the products of the
  // other two, times det P det Q. Adding it makes a rank-2 matrix regular without changing its
  // rotation.
  Mat3 X = unit + c;
  for (int round = 0; round < 30; ++round) {
    const Mat3 inverse = cofactors(X) / X.col(0).dot(X.col(1).cross(X.col(2)));  // X⁻ᵀ
    const double scale = std::sqrt(inverse.norm() / X.norm());
    const Mat3 next = 0.5 * (scale * X + inverse / scale);
    const double change = (next - X).norm();
    X = next;
    if (change < 1e-8) break;  // convergence is quadratic: the next change would be below rounding
  }
  // A final unscaled step removes the rounding errors of the columns.
  return 0.5 * (X + cofactors(X) / X.col(0).dot(X.col(1).cross(X.col(2))));
}

std::optional<Mat3> deformation_gradient(std::span<const int> corners, const Points& before,
                                         const Points& after) {
  if (corners.size() != 3) return std::nullopt;
  Eigen::Matrix<double, 3, 2> E, F;
  for (int k = 0; k < 2; ++k) {
    E.col(k) = (before.row(corners[k + 1]) - before.row(corners[0])).transpose();
    F.col(k) = (after.row(corners[k + 1]) - after.row(corners[0])).transpose();
  }
  const Mat2 G = E.transpose() * E;
  const double det = G.determinant(), trace = G.trace();
  if (!(det > 1e-6 * trace * trace)) return std::nullopt;
  return F * (G.inverse() * E.transpose());
}

Mat3 rotation_of_face(std::span<const int> corners, const Points& before, const Points& after) {
  if (corners.empty()) return Mat3::Identity();
  if (const auto H = deformation_gradient(corners, before, after)) return nearest_rotation(*H);
  const auto count = static_cast<double>(corners.size());
  // Relative to the first corner: far from the origin, plain sums would lose digits.
  const Vec3 from = before.row(corners[0]), to = after.row(corners[0]);
  Vec3 mean_before = Vec3::Zero(), mean_after = Vec3::Zero();
  for (const int v : corners) {
    mean_before += (before.row(v).transpose() - from) / count;
    mean_after += (after.row(v).transpose() - to) / count;
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  Rows u(static_cast<long>(corners.size()), 3), moved = u;  // Uᵀ, U'ᵀ
  for (size_t j = 0; j < corners.size(); ++j) {
    u.row(static_cast<long>(j)) = before.row(corners[j]) - (from + mean_before).transpose();
    moved.row(static_cast<long>(j)) = after.row(corners[j]) - (to + mean_after).transpose();
  }
  const auto [U, lengths, V] = thin_svd(u);
  Mat3 H = Mat3::Zero();
  for (long d = 0; d < lengths.size() && lengths[d] > 1e-12 * lengths[0]; ++d)
    H += (moved.transpose() * U.col(d) / lengths[d]) * V.col(d).transpose();
  return nearest_rotation(H);
}

Mat3 mean_rotation(std::span<const Mat3> rotations, std::span<const double> weights) {
  if (rotations.size() != weights.size())
    throw InputError("found " + std::to_string(weights.size()) + " weights for " +
                     std::to_string(rotations.size()) + " rotations, expected one for each");
  Mat3 sum = Mat3::Zero();
  for (size_t i = 0; i < rotations.size(); ++i) sum += weights[i] * rotations[i];
  return nearest_rotation(sum);
}

Mat3 median_rotation(std::span<const Mat3> rotations, std::span<const double> weights) {
  Mat3 R = mean_rotation(rotations, weights);
  for (int round = 0; round < 1000; ++round) {
    Mat3 sum = Mat3::Zero();
    for (size_t i = 0; i < rotations.size(); ++i)
      sum += weights[i] / std::max((R - rotations[i]).norm(), 1e-12) * rotations[i];
    const Mat3 next = nearest_rotation(sum);
    const double change = (next - R).norm();
    R = next;
    if (change < 1e-14) break;
  }
  return R;
}

namespace {

constexpr int L = RotationBatch::kLanes;
using Lane = double[L];

BATTEN_INLINE void cofactors(const Lane* m, Lane* c, int l) {
  c[0][l] = m[4][l] * m[8][l] - m[5][l] * m[7][l];
  c[1][l] = m[5][l] * m[6][l] - m[3][l] * m[8][l];
  c[2][l] = m[3][l] * m[7][l] - m[4][l] * m[6][l];
  c[3][l] = m[7][l] * m[2][l] - m[8][l] * m[1][l];
  c[4][l] = m[8][l] * m[0][l] - m[6][l] * m[2][l];
  c[5][l] = m[6][l] * m[1][l] - m[7][l] * m[0][l];
  c[6][l] = m[1][l] * m[5][l] - m[2][l] * m[4][l];
  c[7][l] = m[2][l] * m[3][l] - m[0][l] * m[5][l];
  c[8][l] = m[0][l] * m[4][l] - m[1][l] * m[3][l];
}

BATTEN_INLINE double square(const Lane* m, int l) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += m[k][l] * m[k][l];
  return sum;
}

/// Markley's formula for all lanes. `is_accurate`: 1 if the denominator is large enough, otherwise 0.
BATTEN_CLONES void markley(const Lane* M, Lane* R, double* is_accurate) {
  alignas(64) Lane m[9], c[9], s[6], det, cof, lambda;
  for (int l = 0; l < L; ++l) {
    const double scale = 1 / std::sqrt(square(M, l));
    for (int k = 0; k < 9; ++k) m[k][l] = M[k][l] * scale;  // |m| = 1
    cofactors(m, c, l);
    det[l] = m[0][l] * c[0][l] + m[1][l] * c[1][l] + m[2][l] * c[2][l];
    cof[l] = square(c, l);
    lambda[l] = 1.7320508075688772;  // σ1 + σ2 + σ3 ≤ √3 |m|: Newton's method descends to the
                                     // largest root
  }
  for (int round = 0; round < 8; ++round)
    for (int l = 0; l < L; ++l) {
      const double x = lambda[l], k = x * x - 1;
      const double f = k * k - 8 * x * det[l] - 4 * cof[l];
      lambda[l] = x - f / (4 * x * k - 8 * det[l]);
    }
  for (int l = 0; l < L; ++l) {
    const double x = lambda[l], k = 0.5 * (x * x - 1), zeta = k * x - det[l];
    const double f = 4 * k * k - 8 * x * det[l] - 4 * cof[l];
    const bool good = zeta > 0.05 && std::abs(f) < 1e-13;
    is_accurate[l] = good ? 1 : 0;
    // M Mᵀ is symmetric, stored as 00 01 02 11 12 22.
    for (int r = 0, e = 0; r < 3; ++r)
      for (int q = r; q < 3; ++q, ++e)
        s[e][l] = m[3 * r][l] * m[3 * q][l] + m[3 * r + 1][l] * m[3 * q + 1][l] +
                  m[3 * r + 2][l] * m[3 * q + 2][l];
    const double inverse = 1 / zeta;
    for (int col = 0; col < 3; ++col) {
      const double a = m[col][l], b = m[3 + col][l], d = m[6 + col][l];
      R[col][l] =
          ((k + 1) * a + x * c[col][l] - (s[0][l] * a + s[1][l] * b + s[2][l] * d)) * inverse;
      R[3 + col][l] =
          ((k + 1) * b + x * c[3 + col][l] - (s[1][l] * a + s[3][l] * b + s[4][l] * d)) * inverse;
      R[6 + col][l] =
          ((k + 1) * d + x * c[6 + col][l] - (s[2][l] * a + s[4][l] * b + s[5][l] * d)) * inverse;
    }
  }
  // One step of the polar iteration, R ← (R + R⁻ᵀ) / 2, removes rounding errors of lengths and
  // angles.
  for (int l = 0; l < L; ++l) {
    cofactors(R, c, l);
    det[l] = 1 / (R[0][l] * c[0][l] + R[1][l] * c[1][l] + R[2][l] * c[2][l]);
  }
  for (int k = 0; k < 9; ++k)
    for (int l = 0; l < L; ++l) R[k][l] = 0.5 * (R[k][l] + c[k][l] * det[l]);
}

}  // namespace

void nearest_rotations(const RotationBatch& M, RotationBatch& R) {
  alignas(64) double is_accurate[L];
  markley(M.a, R.a, is_accurate);
  for (int l = 0; l < L; ++l)
    if (is_accurate[l] != 1) R.set(l, nearest_rotation(M.get(l)));  // M = 0: R is not finite
}

void rotations_of_triangles(std::span<const std::array<int, 3>> triangles,
                            std::span<const int> which, const Points& before, const Points& after,
                            std::span<Mat3> rotations) {
  constexpr size_t lanes = RotationBatch::kLanes;
  RotationBatch gradients, rotation_batch;
  for (size_t first = 0; first < which.size(); first += lanes) {
    const size_t count = std::min(lanes, which.size() - first);
    std::array<bool, lanes> nearly_lines{};
    for (size_t l = 0; l < lanes; ++l) {
      const auto H = l < count ? deformation_gradient(triangles[which[first + l]], before, after)
                               : std::optional(Mat3(Mat3::Identity()));
      nearly_lines[l] = !H;
      gradients.set(static_cast<int>(l), H ? *H : Mat3(Mat3::Identity()));
    }
    nearest_rotations(gradients, rotation_batch);
    for (size_t l = 0; l < count; ++l)
      rotations[first + l] = nearly_lines[l]
                                 ? rotation_of_face(triangles[which[first + l]], before, after)
                                 : rotation_batch.get(static_cast<int>(l));
  }
}

namespace {

Similarity fit(const Points& before, const Points& after, const std::vector<int>& vertices,
               std::optional<double> scale, const std::vector<double>& weights = {}) {
  Similarity best;
  if (vertices.empty()) return best;
  const auto weight = [&](size_t i) { return weights.empty() ? 1.0 : weights[i]; };
  // Sums relative to the first vertex: far from the origin, plain sums would lose digits.
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
  // Collinear points: take the smallest of all rotations that fit.
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
