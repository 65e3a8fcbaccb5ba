// Decompositions of small dense matrices. They are Eigen's, compiled once: in every source that used
// Eigen's own they would take seconds to compile.
#pragma once

#include <span>

#include "batten/core/eigen.h"

namespace batten {

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
