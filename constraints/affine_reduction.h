// SPDX-License-Identifier: MPL-2.0
// Hard linear constraints by elimination of dofs: x = D y + d0.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/containers.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// Parametrisation x = D y + d0 of all solutions of the linear constraints C x = d, with free
/// unknowns y. Minimising E = ½ xᵀK x - Fᵀx under the constraints becomes the smaller,
/// unconstrained problem
///
///     (Dᵀ K D) y = Dᵀ (F - K d0)
///
/// The reduced matrix stays symmetric positive definite, and constraints are satisfied to rounding,
/// whatever the accuracy of the solve. Reference: [Celniker1991], section 6 (X = D Y + D0, DᵀAD).
///
/// D results from sparse Gauss-Jordan elimination of the constraint equations; the pivot of each
/// equation is its largest coefficient. Constrained dofs become linear combinations of the free
/// ones. Redundant constraints are dropped. A contradiction is reported with the names of all
/// constraints involved and its amount.
///
/// Uncoupled sets: D is n×m and is shared by x, y and z (one matrix, three right-hand sides). Sets
/// with coupled constraints: the unknowns are stacked as [x; y; z] and D is 3n×m (one system with
/// up to 3n unknowns).
///
/// F and the right-hand sides d may change without a new factorization: set_values() and set_rhs()
/// leave D unchanged.
class AffineReduction {
 public:
  enum class RhsMode {
    Given,    ///< right-hand sides of the constraint set; contradictions throw ConflictError
    Deferred  ///< right-hand sides are 0 until set_rhs() or set_values() is called
  };
  /// Computes D and d0 in x = D y + d0 (x: all dofs, y: free unknowns) by eliminating the
  /// constraints. A constraint is redundant if, after elimination, its largest remaining
  /// coefficient is at most `dependent` times its original largest coefficient. With
  /// RhsMode::Given, contradictory values throw ConflictError. Polls the current ProgressScope, as
  /// reduce() does, and reports the stage "constraints" to it.
  explicit AffineReduction(const ConstraintSet& constraints, RhsMode values = RhsMode::Given,
                           double dependent = 1e-9);

  /// Whether the unknowns of the coordinates x, y and z are stacked into one vector.
  bool coupled() const { return coupled_; }
  /// Number of dofs of one coordinate. free_count(): number of free unknowns of one coordinate, or
  /// of all three coordinates together if coupled.
  int dof_count() const { return dof_count_; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// Index of the dof that is equal to each free unknown: 0 … n-1 for n dofs per coordinate, or 0 …
  /// 3n-1 in the stacked [x; y; z] if coupled().
  const std::vector<int>& free_dofs() const { return free_dofs_; }
  /// Number of redundant constraints, that is of constraints implied by other constraints.
  int redundant_count() const { return isize(redundant_); }
  /// Indices of the redundant constraints, ascending. A constraint has the index of its row in the
  /// argument of set_rhs().
  std::vector<int> redundant() const;

  /// Matrix D of the reduction x = D y + d0 of the dofs x to the free unknowns y: n×m, or 3n×m if
  /// coupled(), with n = dof_count() and m = free_count().
  const SparseMatrix& D() const { return D_; }
  /// Particular solution d0 of the constraints: the dofs if all free unknowns are 0; n×3, or 3n×1
  /// if coupled().
  const MatX& d0() const { return d0_; }

  /// Sets new right-hand sides of the constraints, taken from a constraint set with the same
  /// coefficients. Only d0() changes; the coefficients in `same_rows` are not read. Throws
  /// ConflictError, and leaves d0() unchanged, if a redundant constraint contradicts others. Cost:
  /// a sparse product and a check of each redundant constraint.
  void set_values(const ConstraintSet& same_rows);
  /// Sets new right-hand sides of the constraints as set_values() does, but from a matrix.
  /// Uncoupled: one row per constraint, with columns x, y, z. Coupled: one column, with three rows
  /// per uncoupled constraint, followed by one row per coupled constraint. Throws InputError if the
  /// number of rows is wrong.
  void set_rhs(const MatX& rhs);
  /// Throws ConflictError if the right-hand sides `rhs` (see set_rhs()) are contradictory; d0()
  /// stays unchanged. Allocates no memory if there is no conflict.
  void check(const MatX& rhs) const;
  /// Particular solution of the constraints (see d0()) for the right-hand sides `rhs` (see
  /// set_rhs()), with as many columns as `rhs`. Contradictions are not detected.
  MatX particular_solution(const MatX& rhs) const;
  /// Matrix R that maps the right-hand sides of the constraints (see set_rhs()) to the particular
  /// solution: d0() = R rhs.
  const SparseMatrix& rhs_to_particular() const { return rhs_to_particular_; }

  /// Converts an elimination order of all n dofs into one of the free unknowns, for
  /// SparseCholesky::analyze().
  std::vector<int> ordering_of_free(const std::vector<int>& dof_order) const;
  /// Chooses the elimination order for the matrix `reduced` = DᵀKD of the free unknowns (D: see
  /// D()): `dof_order` restricted to them, or an empty order, which stands for AMD, if the
  /// constraints cause much fill. Much fill arises if constraints along curves connect dofs that
  /// `dof_order` keeps in separate parts.
  std::vector<int> choose_ordering(const SparseMatrix& reduced, const SparseMatrix& K,
                                   const std::vector<int>& dof_order) const;

  /// Matrix Dᵀ K D of the free unknowns (lower triangle; D: see D()), from the lower triangle of
  /// the n×n matrix K of one coordinate. If coupled(), K may also be a 3n×3n matrix over [x; y; z].
  /// Throws InputError for other sizes.
  SparseMatrix reduce(const SparseMatrix& K) const;
  /// Load Dᵀ (F - K d0) of the free unknowns, with D() and d0(), for the loads F (n×3) on all dofs:
  /// free_count() rows; three columns, or one column if coupled().
  MatX reduce_load(const SparseMatrix& K, const Points& F) const;
  /// All dofs x = D y + d0, with D() and d0(), for the free unknowns y; n×3 even if coupled().
  Points expand(const MatX& y) const;

 private:
  bool coupled_;
  // Redundant constraint: Σ weights · right-hand sides must vanish.
  struct RedundantConstraint {
    int row;
    std::vector<std::pair<int, double>> weights;
    std::vector<std::string> names;
    double own_weight;
  };
  int dof_count_;
  bool selection_ = true;  // D contains only ones: it selects the free dofs
  std::vector<int> free_dofs_;
  std::vector<RedundantConstraint> redundant_;
  SparseMatrix D_, rhs_to_particular_;  // d0 = rhs_to_particular_ · right-hand sides
  MatX d0_;
};

/// Reaction forces r = K x - F that the constraints exert on the dofs, n×3; zero at unconstrained
/// dofs. K is n×n, or 3n×3n over [x; y; z]. r is the gradient of the energy ½ xᵀKx - Fᵀx at the
/// dofs x under the load F.
Points reaction_forces(const SparseMatrix& K, const Points& x, const Points& F);

/// Contribution of one named constraint to the reaction forces, n×3: the sum of Lagrange multiplier
/// · coefficients over the equations of the constraint.
struct NamedReaction {
  std::string name;
  Points forces;
};
/// Splits the reaction forces r among the named constraints; the contributions sum to r. The
/// Lagrange multipliers λ solve Cᵀ λ = r in the least-squares sense, with the coefficient matrix C
/// of all constraints. They are unique unless constraints are redundant; then the solution with the
/// smallest norm is used.
std::vector<NamedReaction> named_reactions(const ConstraintSet& constraints,
                                           const Points& reaction);

}  // namespace batten
