#include "batten/mesh/rotation_fitting.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/dense.h"
#include "batten/core/errors.h"

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
  // The cofactors have the same singular vectors and det P det Q times the products of the other
  // two singular values: added, they make a flat matrix regular and do not change its rotation.
  Mat3 X = unit + c;
  for (int round = 0; round < 30; ++round) {
    const Mat3 inverse = cofactors(X) / X.col(0).dot(X.col(1).cross(X.col(2)));  // X⁻ᵀ
    const double scale = std::sqrt(inverse.norm() / X.norm());
    const Mat3 next = 0.5 * (scale * X + inverse / scale);
    const double change = (next - X).norm();
    X = next;
    if (change < 1e-8) break;  // quadratic: the next would be below rounding
  }
  // One step without scaling takes rounding out of the columns.
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
  // Relative to the first corner: far from the origin the means would lose digits.
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
    throw InputError(std::to_string(weights.size()) + " weights of " +
                     std::to_string(rotations.size()) + " rotations, expected one each");
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

}  // namespace batten
