// Rows that steps keep without elimination: those that tie many dofs. Internal.
#pragma once

#include <memory>

#include "batten/core/sparse_cholesky.h"
#include "batten/fairing/stacked_reduction.h"
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
class HeldRows {
 public:
  /// The rows of a set that are to be held, and the rest, which is to be eliminated.
  static ConstraintSet many_dofs(const ConstraintSet& constraints);
  static ConstraintSet few_dofs(const ConstraintSet& constraints);

  /// `held`: rows of many dofs; the reduction, of the others, must outlive it.
  HeldRows(const ConstraintSet& held, const StackedReduction& reduction, const Surface& surface);

  bool none() const { return rows_.rows() == 0; }
  /// The rows of one coordinate, by dofs.
  const RowMatrix& rows() const { return rows_; }
  /// The rows of all three, by the free unknowns of the reduction.
  const RowMatrix& of_unknowns() const { return stacked_; }
  /// Moves dofs, n×3, which keep the rows of the reduction, onto all rows: by what bends least in
  /// (u, v).
  void put_on(Points& x) const;

 private:
  const StackedReduction& reduction_;
  RowMatrix rows_, stacked_;
  Points values_;
  // Of one coordinate: the rows by its free unknowns, their weights, what a move costs.
  RowMatrix B_;
  VecX weights_;
  SparseCholesky factor_;
};

/// Weights w for the rows of B beside H: each as stiff as `times` what it acts on. Rows of zeros
/// get none.
VecX multiplier_weights(const RowMatrix& B, const VecX& diagonal, double times);

/// s above, and as many columns as g has; `factor` is that of H_w. `miss`: minimises under
/// B s = -miss instead; no rows: 0.
MatX solve_held(const SparseCholesky& factor, const MatX& g, const RowMatrix& B,
                const VecX& weights, const MatX& miss = {});

}  // namespace batten
