// SPDX-License-Identifier: MPL-2.0
// Constraints and springs that are added to or removed from a factored system without refactoring
// (Schur complement, Woodbury formula).
#pragma once

#include <Eigen/Cholesky>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// Additional constraints n_k · (u_kᵀ y) = g_k on the unknowns y (m×3) that minimise tr(yᵀ N y) - 2
/// tr(fᵀ y), where N is factored. Hard constraints are satisfied exactly and may couple x, y and z.
/// Soft constraints (springs) add s_k (n_k · (u_kᵀ y) - g_k)² to the minimised function. With
/// y⁰ = N⁻¹ f, z_k = N⁻¹ u_k and the constraint matrix G:
///
///     y = y⁰ - Σ_k z_k λ_k n_kᵀ,     (S + C) λ = G y⁰ - g,     S_kl = (n_k · n_l) u_kᵀ z_l
///
/// C = 0 for hard constraints (S is the Schur complement of the saddle-point system) and 1/s_k for
/// soft ones (Woodbury formula). Finally, y is projected orthogonally onto the hard constraints
/// (project()), so that only rounding errors remain.
///
/// With G = R Q, Q with orthonormal rows and R lower triangular, S is solved as R (R⁻¹ S R⁻ᵀ) Rᵀ,
/// so that nearly dependent constraints do not spoil the accuracy. Soft constraints are scaled by
/// √s_k, so that s_k may be 0 or very large. Redundant hard constraints are left out. These are
/// constraints whose remainder after orthogonalisation is below 1e-9 of their size. contradiction()
/// detects incompatible right-hand sides of redundant constraints.
///
/// Cost of construction: one solve per distinct point (column of U), a sparse QR factorization of
/// the constraints, and O(constraints³) for S. Memory: points × m numbers. apply() costs one axpy
/// of length m per constraint, and a triangular solve of the size of S.
class SchurComplementConstraints {
 public:
  /// One constraint or spring on the unknowns y (m×3): the sum of direction · (uᵀ y) over all terms
  /// equals a right-hand side. u is a column of the sparse matrix U, one per point.
  struct Constraint {
    struct Term {
      int point;       ///< index of the column u of the matrix U
      Vec3 direction;  ///< coefficients of the x, y and z of uᵀ y
      bool operator==(const Term&) const = default;
    };
    int point;
    Vec3 direction;
    double size;  ///< norm of the coefficients over all dofs, before the reduction to free unknowns
    bool soft = false;  ///< true: a spring, whose stiffness is 0 until set_stiffness()
    /// Terms in addition to (`point`, `direction`); empty: the constraint has only one term.
    std::vector<Term> further_terms = {};

    bool operator==(const Constraint&) const = default;
    /// Calls visit(point, direction) for each term of the constraint.
    template <class Visit>
    void terms(const Visit& visit) const {
      visit(point, direction);
      for (const Term& t : further_terms) visit(t.point, t.direction);
    }
    /// Left-hand side of the constraint: the sum of direction · uᵀ y over all terms. `points`: uᵀ y
    /// of all points, one row per point.
    double evaluate(const MatX& points) const {
      double sum = 0;
      terms([&](int p, const Vec3& n) {
        sum += n[0] * points(p, 0) + n[1] * points(p, 1) + n[2] * points(p, 2);
      });
      return sum;
    }
  };
  SchurComplementConstraints() = default;
  /// Prepares constraints on the unknowns of a system that is already factored. `factor`: Cholesky
  /// factor of the m×m system matrix. `U`: m × points; column u evaluates the unknowns y at one
  /// point, as uᵀ y. A hard constraint is redundant if less than `dependent` times its size remains
  /// after orthogonalisation. Throws NoSolutionError if the constraints cannot be factored.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints, double dependent = 1e-9);
  /// Prepares constraints as the constructor without `previous` does, but reuses the solves of
  /// `previous`, an object on the same factor. `reused_columns`: for each column of U, the index of
  /// the equal column in the U of `previous`; -1: no equal column.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints,
                             const SchurComplementConstraints& previous,
                             const std::vector<int>& reused_columns, double dependent = 1e-9);

  bool empty() const { return constraints_.empty(); }
  /// Number of hard and soft constraints. points(): number of points (columns of the matrix U).
  int constraint_count() const { return isize(constraints_); }
  int points() const { return static_cast<int>(U_.cols()); }
  /// Indices of the soft constraints (springs), ascending. set_stiffness() uses this order.
  const std::vector<int>& soft() const { return soft_; }
  /// Indices of the independent hard constraints, ascending. redundant(): indices of the redundant
  /// hard constraints.
  const std::vector<int>& independent() const { return independent_; }
  const std::vector<int>& redundant() const { return redundant_; }
  /// Largest violation of a redundant constraint if the right-hand sides are g, and the index of
  /// the violated constraint; index -1: no constraint is redundant.
  std::pair<double, int> contradiction(const VecX& g) const;
  /// Sets the stiffness, ≥ 0, of each soft constraint, in the order of soft(). Cost:
  /// O(constraints³), dense; allocates no memory. Throws InputError for a wrong size or a negative
  /// value.
  void set_stiffness(const VecX& stiffness);
  /// Applies all constraints: `y` contains the unconstrained solution and is overwritten by the
  /// constrained solution. `g`: one right-hand side per constraint. Allocates no memory.
  void apply(Eigen::Ref<MatX> y, const VecX& g) const;
  /// Projects y orthogonally onto the hard constraints: replaces y by the nearest values that
  /// satisfy these constraints for the right-hand sides g. apply() ends with this projection.
  void project(Eigen::Ref<MatX> y, const VecX& g) const;
  /// Adds the multipliers λ of the last apply() to `sum`, which has one entry per constraint; those
  /// of redundant constraints are 0. Allocates no memory.
  void add_multipliers(Eigen::Ref<VecX> sum) const;
  /// Memory of the dense matrices of the constraints, in bytes.
  size_t bytes() const;

 private:
  void prepare(const SparseCholesky& factor, const SchurComplementConstraints* previous,
               const std::vector<int>& reused_columns, double dependent);
  SparseMatrix hard_constraint_matrix(const std::vector<int>& hard) const;
  // Sorts the constraints into soft, independent and redundant ones and computes R. Returns the
  // coefficients of each redundant constraint with respect to the rows of Q.
  std::vector<VecX> orthogonalise(double dependent);
  void solve_points(const SparseCholesky& factor, const SchurComplementConstraints* previous,
                    const std::vector<int>& reused_columns);  // computes Z
  void form_schur_complement();
  void express_redundant(const std::vector<VecX>& redundant_coefficients);
  double evaluate(const Constraint& row, const Eigen::Ref<const MatX>& y) const;
  // Computes the residuals of the hard constraints into scratch_.
  void residual_of_hard(const Eigen::Ref<const MatX>& y, const VecX& g) const;
  std::vector<Constraint> constraints_;
  std::vector<int> independent_, redundant_, soft_;
  MatX redundant_coefficients_;  // redundant × independent
  SparseMatrix U_;
  MatX Z_;
  MatX R_;  // of the independent constraints
  // R⁻¹ S R⁻ᵀ for the independent hard constraints, followed by the soft ones, unscaled.
  MatX S_;
  VecX roots_;   // √s_k
  MatX scaled_;  // S_ with soft rows and columns scaled, plus 1 on their diagonal
  // Initialised, because copies read its state.
  Eigen::LLT<MatX> schur_ = Eigen::LLT<MatX>(MatX(0, 0));
  mutable VecX multipliers_;  // of the independent and the soft constraints, of the last apply()
  mutable VecX scratch_;      // one number per constraint, so that apply() allocates nothing
};

}  // namespace batten
