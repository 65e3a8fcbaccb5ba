// SPDX-License-Identifier: MPL-2.0
#include "batten/core/eigen.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace batten {

Svd thin_svd(const MatX& A) {
  const Eigen::JacobiSVD<MatX> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Svd full_svd(const MatX& A) {
  const Eigen::JacobiSVD<MatX> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Svd3 svd(const Mat3& A) {
  const Eigen::JacobiSVD<Mat3> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

SymmetricEigen symmetric_eigen(const MatX& A) {
  const Eigen::SelfAdjointEigenSolver<MatX> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

VecX symmetric_eigenvalues(const MatX& A) {
  return Eigen::SelfAdjointEigenSolver<MatX>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigen3 symmetric_eigen(const Mat3& A) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

Vec3 to_rotation_vector(const Mat3& R) {
  const Eigen::AngleAxisd rotation(R);
  return rotation.axis().normalized() * rotation.angle();
}

MatX least_squares(const MatX& A, const MatX& b) {
  return A.completeOrthogonalDecomposition().solve(b);
}

MatX solve_symmetric(const MatX& A, const MatX& b) {
  const Eigen::LDLT<MatX> factor(A);
  if (b.cols() == 1) return factor.solve(VecX(b));  // Eigen is faster with vectors
  return factor.solve(b);
}

Vec2 solve_symmetric_2x2(const Mat2& A, const Vec2& b) { return A.ldlt().solve(b); }

MatX solve_square(const MatX& A, const MatX& b) { return A.partialPivLu().solve(b); }

PrincipalAxes principal_axes(std::span<const Vec3> points) {
  PrincipalAxes result;
  if (points.empty()) return result;
  for (const Vec3& p : points) result.mean += p / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - result.mean) * (p - result.mean).transpose();
  const SymmetricEigen3 eigen = symmetric_eigen(spread);
  result.values = eigen.values;
  result.axes = eigen.vectors;
  return result;
}

}  // namespace batten
