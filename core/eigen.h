// SPDX-License-Identifier: MPL-2.0
// Short names for the Eigen types used in Batten, and decompositions of small dense matrices.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <limits>
#include <span>
#include <vector>

namespace batten {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using VecX = Eigen::VectorXd;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using MatX = Eigen::MatrixXd;

/// n points, or n dofs with three components each: one row per point or dof, columns x, y, z.
/// Stored by columns, so that the coordinates are three right-hand sides of one linear system.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Sparse matrix in compressed-column format with 32-bit indices. Symmetric matrices are stored as
/// their lower triangle only; every function with a symmetric matrix as parameter documents this.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Triplet = Eigen::Triplet<double, int>;

/// Positive infinity.
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Decompositions of small dense matrices. These functions call Eigen's decompositions, which are
// instantiated in one source file only. Using Eigen's classes directly would add seconds to the
// compilation of every source file.

/// Singular value decomposition A = U diag(values) Vᵀ of an m×n matrix A, with `values` in
/// descending order. Cost: O(m n²) for m ≥ n.
struct Svd {
  MatX U;
  VecX values;
  MatX V;
};
Svd thin_svd(const MatX& A);  ///< thin SVD of an m×n matrix: U is m×k, V is n×k, k = min(m, n)
Svd full_svd(const MatX& A);  ///< full SVD of an m×n matrix: U is m×m, V is n×n

/// Singular value decomposition U diag(values) Vᵀ of a 3×3 matrix, `values` in descending order.
struct Svd3 {
  Mat3 U;
  Vec3 values;
  Mat3 V;
};
Svd3 svd(const Mat3& A);  ///< SVD of a 3×3 matrix; allocates no memory

/// Eigendecomposition A = vectors diag(values) vectorsᵀ of a symmetric n×n matrix A, with `values`
/// in ascending order. Only the lower triangle of A is read. Cost: O(n³).
struct SymmetricEigen {
  VecX values;
  MatX vectors;
};
SymmetricEigen symmetric_eigen(const MatX& A);
/// Eigenvalues of a symmetric matrix, in ascending order. Only the lower triangle of A is read.
VecX symmetric_eigenvalues(const MatX& A);

/// Eigendecomposition vectors diag(values) vectorsᵀ of a symmetric 3×3 matrix, ascending `values`.
struct SymmetricEigen3 {
  Vec3 values;
  Mat3 vectors;
};
SymmetricEigen3 symmetric_eigen(const Mat3& A);

/// Shortest rotation vector of a rotation matrix R: the unit rotation axis times the angle in [0,
/// π]. Inverse of rotation_matrix() in core/geometry.h. Allocates no memory.
Vec3 to_rotation_vector(const Mat3& R);

/// Least-squares solution of A x = b with minimum norm, for each column of b. Cost: O(m n²) for an
/// m×n matrix A.
MatX least_squares(const MatX& A, const MatX& b);

/// Solution of A x = b for a symmetric n×n matrix A, for each column of b: LDLᵀ factorization with
/// diagonal pivoting. Only the lower triangle of A is read. Cost: O(n³).
MatX solve_symmetric(const MatX& A, const MatX& b);
/// Solution of A x = b for a symmetric 2×2 matrix A; allocates no memory.
Vec2 solve_symmetric_2x2(const Mat2& A, const Vec2& b);

/// Solution of A x = b for a nonsingular n×n matrix A, for each column of b: LU factorization with
/// partial pivoting. Cost: O(n³).
MatX solve_square(const MatX& A, const MatX& b);

/// Principal axes of a point set: the eigenvalues (ascending) and eigenvectors of the scatter
/// matrix Σ (p - mean)(p - mean)ᵀ of its points p. The first axis is the normal of the best-fit
/// plane, the last one the direction of the best-fit line.
struct PrincipalAxes {
  Vec3 mean = Vec3::Zero();
  Vec3 values = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};
/// Computes the principal axes of `points`. If there are no points, the mean and the eigenvalues
/// are 0 and the axes are the identity matrix.
PrincipalAxes principal_axes(std::span<const Vec3> points);

}  // namespace batten
