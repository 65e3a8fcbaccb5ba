// Few rows that mix x, y and z, on a factor that does not. Internal.
#pragma once

#include <Eigen/Cholesky>
#include <utility>
#include <vector>

#include "batten/core/sparse_cholesky.h"

namespace batten {

/// Rows n_k · (u_kᵀ y) = g_k over the unknowns y (m×3), where y minimises ½ tr(yᵀ N y) - tr(fᵀ y).
/// With y⁰ = N⁻¹ f, z_k = N⁻¹ u_k and G the rows as one matrix:
///
///     y = y⁰ - Σ_k z_k λ_k n_kᵀ,     S λ = G y⁰ - g,     S_kl = (n_k · n_l) u_kᵀ z_l
///
/// then projected onto the rows along G itself, which leaves rounding only. G = R Q, Q of
/// orthonormal rows, R lower triangular: S is solved as R (R⁻¹ S R⁻ᵀ) Rᵀ, so that nearly equal rows
/// do no harm. Rows that others imply (what is left of one is below 1e-9 of its size before the
/// reduction) are left out; contradiction() tells when their right-hand sides do not fit. One solve
/// for each different point at construction; m × points numbers are kept.
class Coupling {
 public:
  struct Row {
    int point;       ///< column of U
    Vec3 direction;  ///< unit vector
    double size;     ///< length of the point's coefficients before the reduction
  };
  Coupling() = default;
  /// U: m × points, sparse. Throws NoSolutionError.
  Coupling(const SparseCholesky& factor, SparseMatrix U, std::vector<Row> rows);

  bool empty() const { return rows_.empty(); }
  int rows() const { return static_cast<int>(rows_.size()); }
  /// Rows that the others do not imply, ascending.
  const std::vector<int>& independent() const { return independent_; }
  /// Largest amount by which implied rows are contradicted, for these right-hand sides, and the row
  /// where (-1: there is no implied row).
  std::pair<double, int> contradiction(const VecX& g) const;
  /// y⁰ becomes y.
  void apply(Eigen::Ref<MatX> y, const VecX& g) const;

 private:
  void residual(const Eigen::Ref<const MatX>& y, const VecX& g) const;  // into scratch_
  std::vector<Row> rows_;
  std::vector<int> independent_, implied_;
  MatX implied_by_;  // implied × independent
  SparseMatrix U_;
  MatX Z_;
  MatX R_;                  // of the independent rows
  Eigen::LLT<MatX> schur_;  // R⁻¹ S R⁻ᵀ
  mutable VecX scratch_;    // one number a row, so that apply() allocates nothing
};

}  // namespace batten
