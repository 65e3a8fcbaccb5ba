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
  /// One constraint or spring: the sum of n · (uᵀ y) over its terms equals g.
  struct Constraint {
    struct Term {
      int point;       ///< column u of U
      Vec3 direction;  ///< direction n
      bool operator==(const Term&) const = default;
    };
    int point;
    Vec3 direction;
    double size;        ///< norm of the coefficients over all dofs, before the reduction to y
    bool soft = false;  ///< spring with stiffness 0 until set_stiffness()
    /// Further terms n · (uᵀ y), for a constraint with different directions n at different points.
    std::vector<Term> further_terms = {};

    bool operator==(const Constraint&) const = default;
    /// Calls visit(point, direction) for each term.
    template <class Visit>
    void terms(const Visit& visit) const {
      visit(point, direction);
      for (const Term& t : further_terms) visit(t.point, t.direction);
    }
    /// Left-hand side of the constraint for the values uᵀ y of all points (points × 3).
    double evaluate(const MatX& points) const {
      double sum = 0;
      terms([&](int p, const Vec3& n) {
        sum += n[0] * points(p, 0) + n[1] * points(p, 1) + n[2] * points(p, 2);
      });
      return sum;
    }
  };
  SchurComplementConstraints() = default;
  /// `factor`: Cholesky factor of N. `U`: sparse matrix m × points, whose columns are the u_k. A
  /// hard constraint is redundant if less than `dependent` times its size remains after
  /// orthogonalisation. Throws NoSolutionError if the constraints cannot be factored.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints, double dependent = 1e-9);
  /// Like the constructor above, but reuses the solves of `previous`, an object on the same factor.
  /// `reused_columns`: for each column of U, the index of the equal column of U in `previous`; -1:
  /// none.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints,
                             const SchurComplementConstraints& previous,
                             const std::vector<int>& reused_columns, double dependent = 1e-9);

  bool empty() const { return constraints_.empty(); }
  /// Number of constraints, hard and soft. points(): number of points (columns of U).
  int constraint_count() const { return isize(constraints_); }
  int points() const { return static_cast<int>(U_.cols()); }
  /// Indices of the soft constraints, ascending, in the order of set_stiffness().
  const std::vector<int>& soft() const { return soft_; }
  /// Indices of the independent hard constraints, ascending. redundant(): indices of the redundant
  /// hard constraints.
  const std::vector<int>& independent() const { return independent_; }
  const std::vector<int>& redundant() const { return redundant_; }
  /// Largest violation of a redundant constraint for the right-hand sides g, and the index of that
  /// constraint (-1 if no constraint is redundant).
  std::pair<double, int> contradiction(const VecX& g) const;
  /// Sets the stiffness s_k ≥ 0 of each soft constraint. Cost: O(constraints³), dense; allocates no
  /// memory. Throws InputError for a wrong size or a negative value.
  void set_stiffness(const VecX& stiffness);
  /// Applies all constraints: the unconstrained solution y⁰ in `y` is overwritten by the
  /// constrained one. `g`: one right-hand side per constraint. Allocates no memory.
  void apply(Eigen::Ref<MatX> y, const VecX& g) const;
  /// Projects y orthogonally onto the hard constraints: replaces it by the nearest y that satisfies
  /// them for the right-hand sides g. apply() calls it at its end.
  void project(Eigen::Ref<MatX> y, const VecX& g) const;
  /// Memory of the dense matrices, in bytes.
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
  // Result in scratch_.
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
  mutable VecX scratch_;  // one number per constraint, so that apply() allocates nothing
};

}  // namespace batten
