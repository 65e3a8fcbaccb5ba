// Linear rows on all three coordinates of a surface: [x; y; z] = D y + d0. Internal.
#pragma once

#include <vector>
#include <memory>

#include "batten/constraints/constraint_set.h"
#include "batten/core/eigen.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fem/surface.h"

namespace batten {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// AffineReduction with the coordinates one after the other, whether the rows couple them or not.
class BlockReduction {
 public:
  /// Throws ConflictError.
  explicit BlockReduction(const ConstraintSet& constraints);
  /// The same rows where some dofs (of each coordinate) keep the values that the surface nearest to
  /// `start`, n×3, has: unknowns that they depend on are left out.
  BlockReduction(const BlockReduction& all, const Points& start, const std::vector<char>& frozen);

  /// 3n×m.
  const RowMatrix& D() const { return D_; }
  /// Dofs of one coordinate, n.
  int dof_count() const { return static_cast<int>(D_.rows()) / 3; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// The row of [x; y; z] behind each free unknown.
  const std::vector<int>& free_rows() const { return free_rows_; }
  /// Whether the unknowns are three times those of one coordinate, one coordinate after the other.
  bool coupled() const { return coupled_; }

  /// The free unknowns of these dofs, n×3.
  VecX free_part(const Points& x) const;
  /// D y + d0, n×3.
  Points expand(const VecX& y) const;

 private:
  bool coupled_;
  RowMatrix D_;
  VecX d0_;
  std::vector<int> free_rows_;
};


// Rows that steps keep without elimination: those that tie many dofs. Internal.

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


// What the fairing of a surface expects of its start. Internal.

/// Throws InputError: constraints for another number of dofs, a dof that is not finite, a start
/// without area.
void check_fairing_input(const Surface& start, const ConstraintSet& constraints);

}  // namespace batten
