// Rows that come and go on a factor that stays: hard ones, which may mix x, y and z, and springs.
#pragma once

#include <Eigen/Cholesky>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// Rows n_k · (u_kᵀ y) = g_k over the unknowns y (m×3), where y minimises tr(yᵀ N y) - 2 tr(fᵀ y),
/// and soft rows, which add s_k (n_k · (u_kᵀ y) - g_k)² to that instead. With y⁰ = N⁻¹ f, z_k = N⁻¹
/// u_k and G the rows as one matrix:
///
///     y = y⁰ - Σ_k z_k λ_k n_kᵀ,     (S + C) λ = G y⁰ - g,     S_kl = (n_k · n_l) u_kᵀ z_l
///
/// C = 0 for hard rows and 1/s_k for soft ones (the Schur complement of the saddle point system;
/// for soft rows the Woodbury formula). Then y is projected onto the hard rows along G itself,
/// which leaves rounding only. G = R Q, Q of orthonormal rows, R lower triangular: S is solved as R
/// (R⁻¹ S R⁻ᵀ) Rᵀ, so that nearly equal rows do no harm; soft rows are scaled by √s_k, so that s_k
/// may be 0 or huge. Hard rows that others imply (what is left of one is below 1e-9 of its size
/// before the reduction) are left out; contradiction() tells when their right-hand sides do not
/// fit.
///
/// Cost: one solve for each different point at construction, a sparse QR of the rows and O(rows³) for
/// S; points × m numbers are kept. apply() is as many axpys on m numbers and a triangular solve with
/// as many rows.
class SchurComplementConstraints {
 public:
  struct Constraint {
    struct Term {
      int point;       ///< column of U
      Vec3 direction;  ///< n_k
      bool operator==(const Term&) const = default;
    };
    int point;
    Vec3 direction;
    double size;        ///< length of the row's coefficients before the reduction
    bool soft = false;  ///< stiffness 0 till set_stiffness()
    /// Further terms, for a row whose direction is not the same for all unknowns: Σ n · (uᵀ y).
    std::vector<Term> further_terms = {};

    bool operator==(const Constraint&) const = default;
    /// Calls visit(point, direction) for each term.
    template <class Visit>
    void terms(const Visit& visit) const {
      visit(point, direction);
      for (const Term& t : further_terms) visit(t.point, t.direction);
    }
    /// The row for values uᵀ y of the points (points × 3).
    double evaluate(const MatX& points) const {
      double sum = 0;
      terms([&](int p, const Vec3& n) {
        sum += n[0] * points(p, 0) + n[1] * points(p, 1) + n[2] * points(p, 2);
      });
      return sum;
    }
  };
  SchurComplementConstraints() = default;
  /// U: m × points, sparse. A hard row is implied when less than `dependent` of its size is left.
  /// Throws NoSolutionError.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints, double dependent = 1e-9);
  /// The same, with the solves of an older coupling on the same factor: `reused_columns` is for each column
  /// of U the column of `previous` that equals it, or -1.
  SchurComplementConstraints(const SparseCholesky& factor, SparseMatrix U,
                             std::vector<Constraint> constraints,
                             const SchurComplementConstraints& previous,
                             const std::vector<int>& reused_columns, double dependent = 1e-9);

  bool empty() const { return constraints_.empty(); }
  int constraint_count() const { return isize(constraints_); }
  int points() const { return static_cast<int>(U_.cols()); }
  /// Soft rows, ascending, as set_stiffness() counts them.
  const std::vector<int>& soft() const { return soft_; }
  /// Hard rows that the others do not imply, and those they do; ascending.
  const std::vector<int>& independent() const { return independent_; }
  const std::vector<int>& redundant() const { return redundant_; }
  /// Largest amount by which implied rows are contradicted, for these right-hand sides, and the row
  /// where (-1: there is no implied row).
  std::pair<double, int> contradiction(const VecX& g) const;
  /// s_k ≥ 0 of each soft row. O(rows³), dense; allocates nothing.
  void set_stiffness(const VecX& stiffness);
  /// y⁰ becomes y. g: one number for each row. Allocates nothing.
  void apply(Eigen::Ref<MatX> y, const VecX& g) const;
  /// y onto the hard rows along G: the nearest that holds them. apply() ends with it.
  void project(Eigen::Ref<MatX> y, const VecX& g) const;
  size_t bytes() const;

 private:
  void prepare(const SparseCholesky& factor, const SchurComplementConstraints* previous,
               const std::vector<int>& reused_columns, double dependent);
  SparseMatrix hard_constraint_matrix(const std::vector<int>& hard) const;
  // Sorts the rows into soft, independent and implied ones and makes R. Returns of each implied row
  // its shares of the rows of Q.
  std::vector<VecX> orthogonalise(double dependent);
  void solve_points(const SparseCholesky& factor, const SchurComplementConstraints* previous,
                    const std::vector<int>& reused_columns);  // makes Z
  void form_schur_complement();
  void express_redundant(const std::vector<VecX>& redundant_coefficients);
  double evaluate(const Constraint& row, const Eigen::Ref<const MatX>& y) const;
  void residual_of_hard(const Eigen::Ref<const MatX>& y, const VecX& g) const;  // into scratch_
  std::vector<Constraint> constraints_;
  std::vector<int> independent_, redundant_, soft_;
  MatX redundant_coefficients_;  // implied × independent
  SparseMatrix U_;
  MatX Z_;
  MatX R_;       // of the independent rows
  MatX S_;       // independent rows times R⁻¹ from both sides, then soft ones as they are
  VecX roots_;   // √s_k
  MatX scaled_;  // S_ with soft rows scaled, plus 1 on their diagonal
  Eigen::LLT<MatX> schur_ = Eigen::LLT<MatX>(MatX(0, 0));  // copies read its state
  mutable VecX scratch_;  // one number a row, so that apply() allocates nothing
};

}  // namespace batten
