// SPDX-License-Identifier: MPL-2.0
// Factored constrained systems for interactive use: fixed matrix, changing right-hand sides.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "batten/constraints/affine_reduction.h"

namespace batten {

/// Two mesh vertices per dof: the vertex of a vertex dof, twice, or the ends of an edge dof's edge.
using DofVertices = std::vector<std::array<int, 2>>;

/// Fill-reducing elimination order for the matrix `reduced` = DᵀKD of the free unknowns, with D =
/// reduction.D(), for SparseCholesky::analyze(). It orders the graph of vertices that `reduced`
/// couples (elimination_order()), each vertex with all of its dofs. The dof of an edge follows
/// directly after the end that is eliminated first.
///
/// This graph has a sixth as many nodes as there are unknowns, and is ordered in a tenth of the
/// time. Because all dofs of a vertex stay together, the factor is also smaller than if the
/// unknowns themselves were ordered: by a fifth to a quarter compared with AMD on surface meshes,
/// by half if constraints along curves connect many dofs. Cost: O(entries of `reduced`) and the
/// ordering of the vertices. Throws InputError if `vertices` has the wrong size or the reduction is
/// coupled.
std::vector<int> vertex_ordering(const AffineReduction& reduction, const SparseMatrix& reduced,
                                 const DofVertices& vertices, FactorReuse factor_reuse);

/// Minimises tr(zᵀ S z) - 2 tr(bᵀ z) under C z = d, for a fixed matrix S and changing b and d. With
/// z = D y + R d (AffineReduction of uncoupled constraints, R = rhs_to_particular()):
///
///     N y = Dᵀ b - H d,     N = Dᵀ S D,     H = Dᵀ S R
///
/// N is factored once. Changing b or d costs one pair of triangular solves, one product with D, and
/// one product with H, which is sparse because constraints are local. Both K x = F and implicit
/// time steps have this form. SchurComplementConstraints::apply(), if used, is called between
/// solve() and expand().
///
/// The constructors, set_matrix() and solve() poll the current ProgressScope (cancellation.h).
class ReusableFactorization {
 public:
  /// Reduces the matrix S of one coordinate (lower triangle) to the free unknowns and factors it,
  /// in the vertex_ordering() of `vertices`, or with AMD if `vertices` is empty. Throws InputError
  /// if constraints are coupled or sizes differ, NoSolutionError if the reduced matrix is singular.
  ReusableFactorization(std::shared_ptr<const AffineReduction> reduction, SparseMatrix S,
                        const DofVertices& vertices, FactorReuse factor_reuse = FactorReuse::many);
  /// Factors another matrix S under the same constraints, in the elimination order of `like`: to the
  /// same bits as the constructor above. S must have the pattern of like.matrix().
  ReusableFactorization(const ReusableFactorization& like, SparseMatrix S);

  /// Replaces the values of the matrix S and factors it; the symbolic analysis is reused. Throws
  /// InputError if the sparsity pattern differs. Throws NoSolutionError and restores the previous
  /// matrix if the reduced matrix is singular. After CancelledError, matrix() and H() are the
  /// previous ones, but is_factored() is false, and set_matrix() must be called again before the
  /// next solve.
  void set_matrix(SparseMatrix S);
  bool is_factored() const { return factor_.is_factored(); }

  const SparseMatrix& matrix() const { return S_; }
  const AffineReduction& reduction() const { return *reduction_; }
  const SparseCholesky& factor() const { return factor_; }
  /// Matrix H = Dᵀ S R with D = reduction().D() and R = reduction().rhs_to_particular(): the values
  /// d of the constraints contribute -H d to the right-hand side of the reduced system.
  const SparseMatrix& H() const { return H_; }
  /// Number of free unknowns of one coordinate.
  int free_count() const { return reduction_->free_count(); }

  /// Sets the right-hand side `to` of the reduced system to the contribution -H() d of the
  /// constraints, or to zero if there are no constraints. `d`: values of the constraints, one row
  /// per constraint, three columns.
  void start_load(const MatX& d, MatX& to) const;
  /// Adds the load b (n×3) to the right-hand side `to` of the reduced system: to += Dᵀ b with D =
  /// reduction().D().
  void add_load(const Points& b, MatX& to) const { to.noalias() += D().transpose() * b; }
  /// Solves the reduced system for the free unknowns in place: the right-hand side in `y` is
  /// overwritten by the solution.
  void solve(MatX& y) const { factor_.solve_in_place(y); }
  /// Computes all dofs z = D y + e from the free unknowns y, with D = reduction().D(). `e`:
  /// contribution of the constraint values (the particular solution); n×3, zero at free dofs. `z`
  /// must already have n rows.
  void expand(const MatX& y, const Points& e, Points& z) const;

  /// Memory of the Cholesky factor and of the stored matrices, in bytes.
  size_t bytes() const;

 private:
  const SparseMatrix& D() const { return reduction_->D(); }
  // `reduced`: DᵀSD; `analyzes`: whether its pattern is not analysed yet.
  void factorize(const SparseMatrix& S, const SparseMatrix& reduced, bool analyzes);
  void check(const SparseMatrix& S) const;
  SparseMatrix columns_of_constrained(const SparseMatrix& S) const;
  std::shared_ptr<const AffineReduction> reduction_;
  // Row of the reduction matrix D for a constrained dof: entries begin … end-1 of terms_. Rows of
  // free dofs contain a single 1 and are not stored.
  struct ConstrainedDof {
    int dof, begin, end;
  };
  std::vector<ConstrainedDof> constrained_dofs_;
  std::vector<std::pair<int, double>> terms_;
  void prepare_expansion();
  SparseMatrix S_, H_;
  std::shared_ptr<const std::vector<int>> order_;  // given to the analysis
  SparseCholesky factor_;
};

}  // namespace batten
