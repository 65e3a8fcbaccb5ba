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
    Given,    ///< d0 is computed from the values in the set; contradictions throw ConflictError
    Deferred  ///< d0 is zero until set_rhs() or set_values() is called
  };
  /// Eliminates the constraints. A constraint is redundant if, after elimination, its largest
  /// remaining coefficient is at most `dependent` times its original largest coefficient. With
  /// RhsMode::Given, contradictory values throw ConflictError.
  explicit AffineReduction(const ConstraintSet& constraints, RhsMode values = RhsMode::Given,
                           double dependent = 1e-9);

  /// Whether the unknowns of the coordinates x, y and z are stacked into one vector.
  bool coupled() const { return coupled_; }
  /// Number of dofs of one coordinate. free_count(): number of free unknowns of one coordinate, or
  /// of all three coordinates together if coupled.
  int dof_count() const { return dof_count_; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// Dof that corresponds to each free unknown: 0 … n-1, or 0 … 3n-1 in [x; y; z] if coupled.
  const std::vector<int>& free_dofs() const { return free_dofs_; }
  /// Number of constraints that are implied by others.
  int redundant_count() const { return isize(redundant_); }
  /// Indices of the redundant constraints, ascending. A constraint has the index of its row in the
  /// argument of set_rhs().
  std::vector<int> redundant() const;

  /// Matrix D in x = D y + d0: n×m, or 3n×m if coupled, with m = free_count().
  const SparseMatrix& D() const { return D_; }
  /// Particular solution d0 in x = D y + d0, the dofs for y = 0: n×3, or 3n×1 if coupled.
  const MatX& d0() const { return d0_; }

  /// Sets new right-hand sides, taken from a set with the same constraints. Only d0 changes; the
  /// coefficients in `same_rows` are not read. Throws ConflictError if a redundant constraint
  /// contradicts the others; d0 is then unchanged. Cost: a sparse product and a check of each
  /// redundant constraint.
  void set_values(const ConstraintSet& same_rows);
  /// Like set_values(), with the right-hand sides given as a matrix. Uncoupled: one row per
  /// constraint, with columns x, y, z. Coupled: one column, with three rows per uncoupled
  /// constraint, followed by one row per coupled constraint. Throws InputError if the number of
  /// rows is wrong.
  void set_rhs(const MatX& rhs);
  /// Throws the ConflictError that set_rhs(rhs) would throw, without changing d0. Allocates no
  /// memory if there is no conflict.
  void check(const MatX& rhs) const;
  /// Particular solution d0 for the given right-hand sides (see set_rhs()), with as many columns as
  /// `rhs`. Contradictions are not detected.
  MatX particular_solution(const MatX& rhs) const;
  /// Matrix R that maps right-hand sides to the particular solution: d0 = R rhs, see set_rhs().
  const SparseMatrix& rhs_to_particular() const { return rhs_to_particular_; }

  /// Converts an elimination order of all n dofs into one of the free unknowns, for
  /// SparseCholesky::analyze().
  std::vector<int> ordering_of_free(const std::vector<int>& dof_order) const;
  /// Elimination order for `reduced` = DᵀKD: `dof_order` restricted to the free unknowns, or an
  /// empty order (AMD) if the constraints cause much fill. This happens if constraints along curves
  /// connect dofs that `dof_order` keeps in separate parts.
  std::vector<int> choose_ordering(const SparseMatrix& reduced, const SparseMatrix& K,
                                   const std::vector<int>& dof_order) const;

  /// Reduced matrix Dᵀ K D (lower triangle), from the lower triangle of the n×n matrix K of one
  /// coordinate. If coupled, K may also be a 3n×3n matrix over [x; y; z]. Throws InputError for
  /// other sizes.
  SparseMatrix reduce(const SparseMatrix& K) const;
  /// Reduced load Dᵀ (F - K d0): free_count() rows; three columns, or one column if coupled.
  MatX reduce_load(const SparseMatrix& K, const Points& F) const;
  /// Dofs x = D y + d0 for the free unknowns y; n×3, also if coupled.
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
/// dofs. K is n×n, or 3n×3n over [x; y; z]. r is the gradient of the energy E = ½ xᵀKx - Fᵀx.
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
