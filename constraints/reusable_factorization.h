// What is solved at every event of a drag: one matrix, many right-hand sides.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "batten/constraints/affine_reduction.h"

namespace batten {

/// Of each dof: its vertex, twice; of a dof of an edge: the two ends.
using DofVertices = std::vector<std::array<int, 2>>;

/// An order to factor `reduced` = DᵀKD in, for SparseCholesky::analyze: vertices are ordered in the
/// graph of those that `reduced` couples (elimination_order), each with all of its dofs, and the
/// dof of an edge comes right behind the end that is eliminated first. A graph with a sixth of the
/// unknowns is ordered in a tenth of the time, and because vertices and edges stay together the
/// factor is smaller than in an order of the unknowns: by a fifth to a quarter against AMD on
/// sheets, by half where rows along curves tie dofs together. O(entries of `reduced`), and the
/// order of the vertices. Throws InputError: vertices of another number of dofs; a coupled
/// reduction.
std::vector<int> vertex_ordering(const AffineReduction& reduction, const SparseMatrix& reduced,
                                 const DofVertices& vertices, FactorReuse factor_reuse);

/// z minimises tr(zᵀ S z) - 2 tr(bᵀ z) under C z = d: with z = D y + R d (AffineReduction of
/// uncoupled rows, R = rhs_to_particular()),
///
///     N y = Dᵀ b - H d,     N = Dᵀ S D,     H = Dᵀ S R
///
/// N is factored once; b and d may change at every event for the price of a pair of triangular
/// solves, a product with D and one with H, which is as sparse as the rows are local. x = K⁻¹F and
/// implicit steps are both of this form. What the rows of a Coupling add stands between solve() and
/// expand().
class ReusableFactorization {
 public:
  /// S: lower triangle, of one coordinate. Factored in the vertex_ordering of `vertices`; without any,
  /// in AMD's of the unknowns. Throws InputError: coupled rows; NoSolutionError.
  ReusableFactorization(std::shared_ptr<const AffineReduction> reduction, SparseMatrix S,
                        const DofVertices& vertices, FactorReuse factor_reuse = FactorReuse::many);
  /// For the rows of another system, in its order: S must have the pattern of its matrix.
  ReusableFactorization(const ReusableFactorization& like, SparseMatrix S);

  /// Other numbers in the same pattern: the analysis stays. Throws InputError: another pattern;
  /// NoSolutionError (the system is then as it was).
  void set_matrix(SparseMatrix S);

  const SparseMatrix& matrix() const { return S_; }
  const AffineReduction& reduction() const { return *reduction_; }
  const SparseCholesky& factor() const { return factor_; }
  const SparseMatrix& H() const { return H_; }
  /// Free unknowns and dofs of one coordinate.
  int free_count() const { return reduction_->free_count(); }

  /// to = -H d, or 0 when there are no rows. d: rows × 3.
  void start_load(const MatX& d, MatX& to) const;
  /// to += Dᵀ b.
  void add_load(const Points& b, MatX& to) const { to.noalias() += D().transpose() * b; }
  /// y in place of its right-hand side.
  void solve(MatX& y) const { factor_.solve_in_place(y); }
  /// z = D y + e. `e`: R d, n×3, zero at free dofs. z has n rows already.
  void expand(const MatX& y, const Points& e, Points& z) const;

  size_t bytes() const;

 private:
  const SparseMatrix& D() const { return reduction_->D(); }
  // `reduced`: DᵀSD; `order` of the free unknowns, or null: analysed already.
  void factorize(const SparseMatrix& S, const SparseMatrix& reduced, const std::vector<int>* order);
  void check(const SparseMatrix& S) const;
  SparseMatrix columns_of_constrained(const SparseMatrix& S) const;
  std::shared_ptr<const AffineReduction> reduction_;
  // D without its ones: constrained dofs by free unknowns.
  struct ConstrainedDof {
    int dof, begin, end;
  };
  std::vector<ConstrainedDof> constrained_dofs_;
  std::vector<std::pair<int, double>> terms_;
  void prepare_expansion();
  SparseMatrix S_, H_;
  SparseCholesky factor_;
};

}  // namespace batten
