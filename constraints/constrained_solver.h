// SPDX-License-Identifier: MPL-2.0
// Solvers for linear systems with hard constraints: static solution for many loads, and implicit
// time integration.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// Solves K x = F under constraints in one call: reduces, factors, solves and expands. Throws
/// ConflictError for contradictory constraints and NoSolutionError for a singular system.
Points solve_constrained(const ConstraintSet& constraints, const SparseMatrix& K, const Points& F);

/// Constrained linear system with a stored factorization, for many loads. All functions poll the
/// current ProgressScope (cancellation.h).
class ConstrainedSolver {
 public:
  /// Eliminates the constraints (AffineReduction) and factors the reduced K (lower triangle).
  ///
  /// `dof_order`: fill-reducing elimination order of all n dofs, for example
  /// nested_dissection_order() of the mesh; empty: automatic. `solver`: linear solver; null:
  /// SparseCholesky. Throws ConflictError for contradictory constraints and NoSolutionError for a
  /// singular system.
  ConstrainedSolver(const ConstraintSet& constraints, SparseMatrix K,
                    const std::vector<int>& dof_order = {},
                    std::unique_ptr<LinearSolverBackend> solver = nullptr);
  /// Replaces the constraints and the stiffness matrix, for example after the shape has changed. If
  /// the sparsity pattern of the reduced matrix is unchanged, as usual, the symbolic analysis is
  /// reused. After an exception, only update() may be called.
  void update(const ConstraintSet& constraints, SparseMatrix K);
  /// Solution x (n×3) of K x = F under the constraints, for the load F (n×3). Cost: one pair of
  /// triangular solves.
  Points solve(const Points& F) const;
  /// Solution x (n×3) for the load F (n×3), with one step of iterative refinement whose residual F
  /// - K x is computed in long double. Use it for coupled systems whose soft modes are 1e8 times
  /// softer than their stiff ones, such as thin shells. The result is accurate to about 10 digits
  /// for the matrix K as stored in double precision, whichever back end factored it. Cost: two
  /// solves and one product. Throws InputError if K is not 3n×3n.
  Points solve_refined(const Points& F) const;
  /// Solves the reduced system (DᵀKD) y = b for the free unknowns y, with D = reduction().D(). b is
  /// overwritten by y.
  void solve_reduced(Eigen::Ref<MatX> b) const;
  /// Solves K x = F (F: n×3) for another, similar K (lower triangle) under other constraints
  /// `reduction`, by the conjugate gradient method with the factorization of this solver as the
  /// preconditioner ([HestenesStiefel1952]). K must be 3n×3n.
  ///
  /// `start`: initial guess of the free unknowns, n×3, such as the solution of this solver. Stops
  /// when √(rᵀ z) ≤ `tolerance`, with the residual r and the preconditioned residual z: this
  /// estimates the error in the energy norm, √(eᵀ K e). The residual is then computed anew to confirm
  /// it. Returns nullopt if `max_iterations` are not enough, or if the constraints leave other
  /// unknowns free than those of this solver. Cost per iteration: one product and one pair of
  /// triangular solves.
  std::optional<Points> solve_similar(const AffineReduction& reduction, const SparseMatrix& K,
                                      const Points& F, const Points& start, double tolerance,
                                      int max_iterations) const;
  const AffineReduction& reduction() const { return reduction_; }
  const SparseMatrix& K() const { return K_; }

 private:
  void factor(SparseMatrix& K);  // takes K

  AffineReduction reduction_;
  SparseMatrix K_;
  std::vector<int> dof_order_;
  std::unique_ptr<LinearSolverBackend> solver_;
  MatX fixed_part_;  // -Dᵀ K d0
};

// Implicit time integration of a curve or surface under loads.

/// Theta method for M (ρ ẍ + μ ẋ) + K x = F under linear constraints, x = D y + d0:
///
///     v_θ = θ v₁ + (1 - θ) v₀                    velocity used for the step
///     [ρ/(θ dt) M + μ M + θ dt K] v_θ = F - K x₀ + ρ/(θ dt) M v₀        reduced by D
///     x₁ = x₀ + dt v_θ
///
/// It is unconditionally stable for ½ ≤ θ ≤ 1. θ = 1 (implicit Euler, first order) damps modes that
/// the step cannot resolve, and reaches the static solution in one step as dt → ∞. θ = ½
/// (trapezoidal rule, second order) preserves the energy balance exactly: per step, the energy
/// changes by the work of F minus μ dt v_θᵀ M v_θ. The energy is
/// E = ½ xᵀKx + ½ ρ vᵀMv.
///
/// One factorization serves as long as K, M, ρ, μ, dt, θ and the constraint coefficients are
/// unchanged; a step is one pair of triangular solves. Reference: [Celniker1991], section 3
/// (ρ ẅ + μ ẇ + L w = f).
class ThetaIntegrator {
 public:
  struct Options {
    double density = 1;  ///< mass density, ≥ 0; density and damping must not both be 0
    double damping = 1;  ///< mass-proportional damping coefficient, ≥ 0
    double dt = 0;       ///< time step, > 0
    double theta = 1;    ///< ½ (trapezoidal rule) to 1 (implicit Euler)
  };
  /// `K`, `M`: lower triangles of the stiffness and mass matrices of one coordinate. Until start()
  /// is called, the velocities and all free unknowns are 0. Throws InputError if sizes differ or
  /// options are out of range, ConflictError for contradictory constraints, NoSolutionError for a
  /// singular system.
  ThetaIntegrator(const ConstraintSet& constraints, SparseMatrix K, SparseMatrix M,
                  const Options& options);

  /// Sets the initial state. The positions x (n×3) must satisfy the constraints, the velocities v
  /// (n×3) the homogeneous constraints (right-hand sides 0). Throws InputError if the sizes are
  /// wrong.
  void start(Points x, Points v);
  /// Advances the motion by one time step under the load F (n×3); returns the new positions.
  const Points& step(const Points& F);

  const Points& positions() const { return x_; }
  const Points& velocities() const { return v_; }
  /// Kinetic energy ½ ρ vᵀMv with the density ρ, the velocities v and the mass matrix M.
  /// potential(): potential energy ½ xᵀKx - Fᵀx of the positions x under the load F. The sum of
  /// kinetic and potential energy never increases under a constant load.
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
