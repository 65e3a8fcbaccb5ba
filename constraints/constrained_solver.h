// Systems under hard constraints: reduced, factored once, solved for many loads.
#pragma once

#include <memory>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/solvers/sparse_cholesky.h"

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


// Motion of a curve or a surface under loads, in implicit steps.

/// M (ρ ẍ + μ ẋ) + K x = F with the constraints of a set, x = D y + d0:
///
///     v_θ = θ v₁ + (1 - θ) v₀                    the velocity that a step goes with
///     [ρ/(θ dt) M + μ M + θ dt K] v_θ = F - K x₀ + ρ/(θ dt) M v₀        reduced by D
///     x₁ = x₀ + dt v_θ
///
/// Unconditionally stable for θ from ½ to 1. θ = 1 (implicit Euler, first order) takes energy out
/// of what the step cannot resolve and reaches the static solution in one step as dt → ∞; θ = ½
/// (the trapezoidal rule, second order) keeps energy exactly: it changes by the work of F minus 2 μ
/// dt v_θᵀ M v_θ in each step, in the sense E = xᵀKx + ρ vᵀMv of the project's energies (twice the
/// physical ones). One factor while K, M, ρ, μ, dt, θ and the constraint rows stand; a step is one
/// pair of triangular solves. Source: Celniker and Gossard 1991, section 3 (ρ ẅ + μ ẇ + L w = f).
class ThetaIntegrator {
 public:
  struct Options {
    double density = 1;  ///< ρ ≥ 0
    double damping = 1;  ///< μ ≥ 0
    double dt = 0;       ///< > 0
    double theta = 1;    ///< ½ … 1
  };
  /// K, M: lower triangles of one coordinate. Throws InputError on sizes that differ, options
  /// outside of their range, ConflictError, NoSolutionError.
  ThetaIntegrator(const ConstraintSet& constraints, SparseMatrix K, SparseMatrix M,
                  const Options& options);

  /// Positions (n×3) that keep the constraints, and velocities that keep their homogeneous rows.
  void start(Points x, Points v);
  /// One step under the load F (n×3).
  const Points& step(const Points& F);

  const Points& positions() const { return x_; }
  const Points& velocities() const { return v_; }
  /// ρ vᵀMv, and xᵀKx - 2 Fᵀx: their sum never grows under a constant F.
  double kinetic() const;
  double potential(const Points& F) const;

 private:
  AffineReduction reduction_;
  SparseMatrix K_, M_, zero_matrix_;
  Options options_;
  SparseCholesky cholesky_;
  Points x_, v_;
};

}  // namespace batten
