// Options of a sculpting session and of its motion.
#pragma once

#include <cstddef>

#include "batten/core/solvers/symbolic_analysis.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/rest_shape_function.h"

namespace batten {

/// Parameters of the motion M (ρ ẍ + μ ẋ) + K x = F (constraints/theta_integrator.h).
struct Motion {
  double dt = 0;       ///< time step; > 0
  double density = 1;  ///< mass density ρ ≥ 0; ρ and μ must not both be 0
  double damping = 1;  ///< damping coefficient μ ≥ 0
  double theta = 1;    ///< parameter θ of the implicit scheme, ½ … 1
};

/// Options of a SculptingSession.
struct SessionOptions {
  /// Initial values of the parameters alpha and beta (or alpha_uu, … beta_vv).
  SurfaceStiffness material;
  /// true: one parameter (isotropic); false: three.
  bool isotropic_alpha = true, isotropic_beta = true;
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< true: constrains only the corners instead of the lines
  /// Called by solve_to_equilibrium() if the constraints have changed since its last call; solves
  /// in between are linear. Empty: no rest shape. See docs/fairness.md.
  RestShapeFunction rest;
  /// once: the session will be solved only once or twice, so a better fill-reducing ordering does
  /// not pay.
  FactorReuse factor_reuse = FactorReuse::many;
  /// solve_to_equilibrium() has converged if no inner dof changes by more than this times the size
  /// in one iteration (slopes count times the size of their triangles). It has also converged if
  /// the largest change is below 1e-9 of the size and no longer decreases.
  double tolerance = 1e-12;
  int max_iterations = 60;
  /// Maximum memory of states and factors in the history, bytes. It keeps at least one step and at
  /// most 256.
  size_t history_bytes = size_t(512) << 20;
  /// Triangle edges are divided into n facets in frames: n² facets per triangle.
  int facets_per_edge = 2;
};

}  // namespace batten
