// Rows that steps keep without elimination: those that tie many dofs. Internal.
#pragma once

#include <memory>

#include "batten/core/sparse_cholesky.h"
#include "batten/fairing/block_reduction.h"
#include "batten/fem/surface.h"

namespace batten {

/// Rows of embedded lines tie the dofs of a triangle to each other, one triangle after the other:
/// eliminated, they would leave unknowns that act on hundreds of triangles. They are held by
/// multipliers instead,
///
///     minimise ½ sᵀHs + gᵀs,  B s = 0:   s = -H_w⁻¹ (g + Bᵀλ),  λ += w B s,   H_w = H + Bᵀ w B,
///
/// a few solves with one factor as sparse as H. Uncoupled rows only. B is made of the rows of one
/// coordinate.
class AugmentedLagrangianConstraints {
 public:
  /// The rows of a set that are to be held, and the rest, which is to be eliminated.
  static ConstraintSet dense_rows(const ConstraintSet& constraints);
  static ConstraintSet sparse_rows(const ConstraintSet& constraints);

  /// `constraints`: rows of many dofs; the reduction, of the others, must outlive it.
  AugmentedLagrangianConstraints(const ConstraintSet& constraints, const BlockReduction& reduction,
                                 const Surface& surface);

  bool empty() const { return rows_.rows() == 0; }
  /// The rows of one coordinate, by dofs.
  const RowMatrix& rows() const { return rows_; }
  /// The rows of all three, by the free unknowns of the reduction.
  const RowMatrix& reduced_rows() const { return block_rows_; }
  /// Moves dofs, n×3, which keep the rows of the reduction, onto all rows: by what bends least in
  /// (u, v).
  void project_onto(Points& x) const;

 private:
  const BlockReduction& reduction_;
  RowMatrix rows_, block_rows_;
  Points values_;
  // Of one coordinate: the rows by its free unknowns, their weights, what a move costs.
  RowMatrix B_;
  VecX weights_;
  SparseCholesky factor_;
};

/// Weights w for the rows of B beside H: each as stiff as `times` what it acts on. Rows of zeros
/// get none.
VecX penalty_weights(const RowMatrix& B, const VecX& diagonal, double times);

/// s above, and as many columns as g has; `factor` is that of H_w. `residual`: minimises under
/// B s = -miss instead; no rows: 0.
MatX solve_augmented_lagrangian(const SparseCholesky& factor, const MatX& g, const RowMatrix& B,
                                const VecX& weights, const MatX& residual = {});

}  // namespace batten
