// Motion of a curve or a surface under loads, in implicit steps.
#pragma once

#include "batten/constraints/affine_reduction.h"

namespace batten {

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
