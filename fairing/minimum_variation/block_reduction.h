// SPDX-License-Identifier: MPL-2.0
// Reduction of linear constraints on all three coordinates of a surface to free unknowns, [x; y; z]
// = D y + d0; and constraints imposed by Lagrange multipliers.
#pragma once

#include <memory>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/eigen.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fem/surface.h"

namespace batten {

using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// AffineReduction with stacked coordinates [x; y; z], for constraint sets that couple the
/// coordinates and for those that do not.
class BlockReduction {
 public:
  /// Throws ConflictError if constraints contradict each other.
  explicit BlockReduction(const ConstraintSet& constraints);
  /// Restricts a reduction by freezing dofs (all three coordinates of each).
  ///
  /// Frozen dofs keep the values that they have after `start`, n×3, has been projected onto the
  /// constraints. All unknowns on which they depend are removed. `frozen`: n entries.
  BlockReduction(const BlockReduction& all, const Points& start, const std::vector<char>& frozen);

  /// Matrix D of the reduction, 3n×m.
  const RowMatrix& D() const { return D_; }
  /// Number of dofs per coordinate, n.
  int dof_count() const { return static_cast<int>(D_.rows()) / 3; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// Row of [x; y; z] that each free unknown stands for.
  const std::vector<int>& free_rows() const { return free_rows_; }
  /// True if the constraints couple x, y and z. Otherwise the unknowns are three equal blocks, one
  /// per coordinate.
  bool coupled() const { return coupled_; }

  /// Values of the free unknowns in the dofs `x`, n×3.
  VecX free_part(const Points& x) const;
  /// All dofs, D y + d0, as an n×3 array.
  Points expand(const VecX& y) const;

 private:
  bool coupled_;
  RowMatrix D_;
  VecX d0_;
  std::vector<int> free_rows_;
};

// Constraints imposed by multipliers instead of elimination, because they involve many dofs.

/// Augmented-Lagrangian treatment of constraints with many dofs.
///
/// The constraints of an embedded line connect the dofs of its triangles, one triangle after the
/// other. Eliminating them would leave unknowns that act on hundreds of triangles. They are imposed
/// by Lagrange multipliers instead (method of multipliers),
///
///     minimise ½ sᵀHs + gᵀs,  B s = 0:   s = -H_w⁻¹ (g + Bᵀλ),  λ += w B s,   H_w = H + Bᵀ w B,
///
/// which takes a few solves with one factor as sparse as that of H. For uncoupled constraints only.
/// B has one row per constraint of one coordinate.
class AugmentedLagrangianConstraints {
 public:
  /// Splits a set: constraints with 9 dofs or more, which are imposed by multipliers, and the
  /// others, which are eliminated. All constraints of a coupled set count as sparse.
  static ConstraintSet dense_rows(const ConstraintSet& constraints);
  static ConstraintSet sparse_rows(const ConstraintSet& constraints);

  /// `constraints`: dense_rows() of a set. `reduction`: that of the sparse rows; it must outlive
  /// this object.
  AugmentedLagrangianConstraints(const ConstraintSet& constraints, const BlockReduction& reduction,
                                 const Surface& surface);

  bool empty() const { return rows_.rows() == 0; }
  /// Constraints of one coordinate in terms of all dofs.
  const RowMatrix& rows() const { return rows_; }
  /// Constraints of all three coordinates in terms of the free unknowns of the reduction.
  const RowMatrix& reduced_rows() const { return block_rows_; }
  /// Projects dofs, n×3, that satisfy the reduction onto all constraints, with the correction of
  /// least bending energy in (u, v).
  void project_onto(Points& x) const;

 private:
  const BlockReduction& reduction_;
  RowMatrix rows_, block_rows_;
  Points values_;
  // For one coordinate: constraints in terms of its free unknowns, their penalty weights, and the
  // factor of the bending energy.
  RowMatrix B_;
  VecX weights_;
  SparseCholesky factor_;
};

/// Penalty weights w for the constraints B beside H: each is `times` as stiff as the unknowns that
/// it acts on. `diagonal`: of H. Zero rows get weight 0.
VecX penalty_weights(const RowMatrix& B, const VecX& diagonal, double times);

/// Solves for s of AugmentedLagrangianConstraints, with as many columns as g. `factor`: that of
/// H_w. If `residual` is given, the constraint is B s = -residual. If B has no rows, this is one
/// plain solve.
MatX solve_augmented_lagrangian(const SparseCholesky& factor, const MatX& g, const RowMatrix& B,
                                const VecX& weights, const MatX& residual = {});

// Input checks shared by the fairing of surfaces.

/// Throws InputError for constraints on another number of dofs, for a dof that is not finite, and
/// for a start without area.
void check_fairing_input(const Surface& start, const ConstraintSet& constraints);

}  // namespace batten
