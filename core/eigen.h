// Eigen types under one set of names, and infinity.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <limits>
#include <vector>
#include <span>

namespace batten {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using VecX = Eigen::VectorXd;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using MatX = Eigen::MatrixXd;

/// n points or n dof triples, one a row: columns are x, y, z. Column-major, so that the three
/// coordinates are three right-hand sides of one factor.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Compressed columns, 32-bit indices. Symmetric matrices are kept by their lower triangle only,
/// and every function that takes one says so.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Triplet = Eigen::Triplet<double, int>;

/// Larger than every number.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();


// Decompositions of small dense matrices. They are Eigen's, compiled once: in every source that used
// Eigen's own they would take seconds to compile.

/// A = U diag(values) Vᵀ, the largest value first. O(m n²) for m ≥ n.
struct Svd {
  MatX U;
  VecX values;
  MatX V;
};
Svd thin_svd(const MatX& A);  ///< U is m × k and V n × k, with k = min(m, n)
Svd full_svd(const MatX& A);  ///< U is m × m and V n × n

struct Svd3 {
  Mat3 U;
  Vec3 values;
  Mat3 V;
};
Svd3 svd(const Mat3& A);  ///< allocates nothing

/// A = vectors diag(values) vectorsᵀ of a symmetric A, of which the lower triangle is read; the smallest
/// value first. O(n³).
struct SymmetricEigen {
  VecX values;
  MatX vectors;
};
SymmetricEigen symmetric_eigen(const MatX& A);
VecX symmetric_eigenvalues(const MatX& A);

struct SymmetricEigen3 {
  Vec3 values;
  Mat3 vectors;
};
SymmetricEigen3 symmetric_eigen(const Mat3& A);

/// x of least norm among those of least |A x - b|, column by column. O(m n²).
MatX least_squares(const MatX& A, const MatX& b);

/// Where points are, and how they spread: the eigenvalues and eigenvectors of Σ (p - mean)(p - mean)ᵀ. The
/// first axis is the normal of the best plane, the last the direction of the best line.
struct PrincipalAxes {
  Vec3 mean = Vec3::Zero();
  Vec3 values = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};
PrincipalAxes principal_axes(std::span<const Vec3> points);

}  // namespace batten
