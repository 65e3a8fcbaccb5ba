// Hard constraints by elimination: x = D y + d0.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/containers.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// All x that satisfy C x = d, written as x = D y + d0 with free y. Minimising
/// E = xᵀK x - 2 Fᵀx over them is then the smaller, unconstrained problem
///
///     (Dᵀ K D) y = Dᵀ (F - K d0)
///
/// which keeps K symmetric positive definite and holds the constraints to rounding whatever the
/// solve does. Source: Celniker and Gossard 1991, section 6 (X = D Y + D0, DᵀAD).
///
/// D comes from sparse Gauss-Jordan elimination of the rows, each pivoting on its largest
/// coefficient: constrained dofs become combinations of the free ones, free dofs stay themselves.
/// A row that others imply is dropped; one that contradicts them is reported with the names of all
/// constraints that take part and the amount.
///
/// Uncoupled sets: D is n×m and serves x, y, z at once (one matrix, three right-hand sides).
/// A set with coupled rows: the unknowns are stacked, [x; y; z], D is 3n×m (one system of up to
/// 3n).
///
/// Which inputs may change without a new factor: F and the right-hand sides d (set_values(): D is
/// the same).
class AffineReduction {
 public:
  enum class RhsMode {
    Given,    ///< d0 follows from the values in the set: throws ConflictError
    Deferred  ///< set_rhs() will tell them; d0 is zero till then
  };
  /// A row of which no more than `dependent` of its largest coefficient is left is implied.
  explicit AffineReduction(const ConstraintSet& constraints, RhsMode values = RhsMode::Given,
                           double dependent = 1e-9);

  bool coupled() const { return coupled_; }
  /// Unknowns that stay free: of each coordinate, or of all three when coupled.
  int dof_count() const { return dof_count_; }
  int free_count() const { return static_cast<int>(D_.cols()); }
  /// The dof behind each free unknown (0 … n-1, or 0 … 3n-1 of [x; y; z] when coupled).
  const std::vector<int>& free_dofs() const { return free_dofs_; }
  /// Rows that were implied by others.
  int redundant_count() const { return isize(redundant_); }
  /// Which ones, as set_rhs() counts them.
  std::vector<int> redundant() const;

  const SparseMatrix& D() const { return D_; }
  /// n×3, or 3n×1 when coupled.
  const MatX& d0() const { return d0_; }

  /// Other right-hand sides for the same rows (their coefficients are not looked at again): only d0
  /// changes. A sparse product, and a look at each row that others imply: ConflictError when it is
  /// contradicted now (d0 then stays as it was).
  void set_values(const ConstraintSet& same_rows);
  /// The same with the right-hand sides as a matrix, one row for each row of the set: its value
  /// (×3). When coupled (×1): three rows for each uncoupled row, then one for each coupled one.
  void set_rhs(const MatX& rhs);
  /// The ConflictError of set_rhs(), without setting anything. Allocates nothing when there is
  /// none.
  void check(const MatX& rhs) const;
  /// The d0 of any right-hand sides, in as many columns as they have. Contradictions are not looked
  /// for.
  MatX particular_solution(const MatX& rhs) const { return rhs_to_particular_ * rhs; }
  /// d0 = rhs_to_particular() · right-hand sides.
  const SparseMatrix& rhs_to_particular() const { return rhs_to_particular_; }

  /// An order of all n dofs as an order of the free unknowns, for SparseCholesky::analyze.
  std::vector<int> ordering_of_free(const std::vector<int>& dof_order) const;
  /// The order to factor DᵀKD in: that of the dofs, or none (AMD) where rows along curves tie dofs
  /// together across the parts that an order of the mesh keeps apart.
  std::vector<int> choose_ordering(const SparseMatrix& reduced, const SparseMatrix& K,
                                   const std::vector<int>& dof_order) const;

  /// Dᵀ K D, lower triangle, from the lower triangle of the n×n matrix K of one coordinate; when
  /// coupled also from a 3n×3n one over [x; y; z]. Throws InputError for another size.
  SparseMatrix reduce(const SparseMatrix& K) const;
  /// Dᵀ (F - K d0): free_count × 3, or × 1 when coupled.
  MatX reduce_load(const SparseMatrix& K, const Points& F) const;
  /// x = D y + d0, always n×3.
  Points expand(const MatX& y) const;

 private:
  bool coupled_;
  // A row that the others imply: Σ shares · right-hand sides has to vanish.
  struct RedundantConstraint {
    int row;
    std::vector<std::pair<int, double>> weights;
    std::vector<std::string> names;
    double own_weight;
  };
  int dof_count_;
  bool selection_ = true;  // D only picks dofs
  std::vector<int> free_dofs_;
  std::vector<RedundantConstraint> redundant_;
  SparseMatrix D_, rhs_to_particular_;  // d0 = rhs_to_particular_ · right-hand sides
  MatX d0_;
};

/// Forces that the constraints exert on the dofs: r = K x - F, n×3. Zero on free dofs. K is n×n, or
/// 3n×3n over [x; y; z].
/// In the sense of the energy E = xᵀKx - 2Fᵀx = 2 (½xᵀKx - Fᵀx): r is the force of the second form.
Points reaction_forces(const SparseMatrix& K, const Points& x, const Points& F);

/// The share of each named constraint in the reaction: Σ over its rows of multiplier · row, n×3.
/// The multipliers solve Cᵀ λ = r in the least-squares sense; they are unique when no row is
/// redundant, otherwise the smallest are taken. Sum over names: r.
struct NamedReaction {
  std::string name;
  Points forces;
};
std::vector<NamedReaction> named_reactions(const ConstraintSet& constraints,
                                           const Points& reaction);

}  // namespace batten
