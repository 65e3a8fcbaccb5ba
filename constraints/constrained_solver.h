// Systems under hard constraints: reduced, factored once, solved for many loads.
#pragma once

#include <memory>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/linear_solver_backend.h"
#include "batten/core/sparse_cholesky.h"

namespace batten {

/// Reduce, factor, solve, expand in one call. Throws ConflictError, NoSolutionError.
Points solve_constrained(const ConstraintSet& constraints, const SparseMatrix& K, const Points& F);

/// The same with the factor kept, for many loads.
class ConstrainedSolver {
 public:
  /// `dof_order`: all n dofs in a fill-reducing order (nested_dissection_order of a mesh), or none.
  /// Throws ConflictError, NoSolutionError.
  /// `factor`: what factors DᵀKD; none: SparseCholesky.
  ConstrainedSolver(const ConstraintSet& constraints, SparseMatrix K,
                    const std::vector<int>& dof_order = {},
                    std::unique_ptr<LinearSolverBackend> factor = nullptr);
  /// Other numbers: those of a shape that has moved. Where the pattern of DᵀKD is the same, as it
  /// mostly is, nothing is analysed again. After a throw only update() may be called.
  void update(const ConstraintSet& constraints, SparseMatrix K);
  /// One pair of triangular solves.
  Points solve(const Points& F) const;
  /// The same for coupled systems whose soft motions are 1e8 times as soft as their stiff ones, such as
  /// thin shells: one step of iterative refinement, its residual F - K q in long double. What 16 digits
  /// of K tell is then right to some 10 digits, whatever factored it. Costs two solves and a product.
  /// Throws InputError for a K that is not 3n×3n.
  Points solve_refined(const Points& F) const;
  /// The same on free unknowns: DᵀKD y = b, b becomes y.
  void solve_reduced(Eigen::Ref<MatX> b) const;
  const AffineReduction& reduction() const { return reduction_; }
  const SparseMatrix& K() const { return K_; }

 private:
  void factor(SparseMatrix K);

  AffineReduction reduction_;
  SparseMatrix K_;
  std::vector<int> dof_order_;
  SparseCholesky cholesky_;
  std::unique_ptr<LinearSolverBackend> backend_;  // in its place
  MatX fixed_part_;                               // -Dᵀ K d0
};

}  // namespace batten
