// SPDX-License-Identifier: MPL-2.0
// Options of a sculpting session and of its motion.
#pragma once

#include <cstddef>

#include "batten/core/solvers/supernodal_factor.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {

/// Parameters of the motion M (ρ ẍ + μ ẋ) + K x = F; see ThetaIntegrator.
struct Motion {
  double dt = 0;       ///< time step; > 0
  double density = 1;  ///< mass density ρ, ≥ 0; density and damping must not both be 0
  double damping = 1;  ///< damping coefficient μ, ≥ 0
  double theta = 1;    ///< parameter of the theta method, ½ … 1; see ThetaIntegrator
};

/// Options of a SculptingSession.
struct SessionOptions {
  /// Initial stretching and bending stiffness: parameters alpha and beta (or alpha_uu, … beta_vv).
  SurfaceStiffness material;
  /// True: alpha (or beta) is one parameter, an isotropic stiffness. False: three parameters with
  /// the suffixes _uu, _uv and _vv.
  bool isotropic_alpha = true, isotropic_beta = true;
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< true: constrains only the corners, not the whole curves
  /// Computes the rest shape. solve_to_equilibrium() calls it if the constraints have changed since
  /// the last call; solves in between are linear. Empty: no rest shape. See docs/fairness.md.
  RestShapeFunction rest;
  /// Use FactorReuse::once if the session will be solved only once or twice, so that a better
  /// fill-reducing ordering does not pay off.
  FactorReuse factor_reuse = FactorReuse::many;
  /// Convergence tolerance of solve_to_equilibrium(): in one iteration, no unconstrained dof
  /// changes by more than `tolerance` times the model size (slopes are multiplied by the size of
  /// their triangles). The solve has also converged if the largest change is below 1e-9 of the
  /// model size and no longer decreases.
  double tolerance = 1e-12;
  int max_iterations = 60;
  /// Maximum memory of the undo history, bytes; 0: no history. The history keeps at least one step
  /// and at most 1,000. Factors and matrices are dropped before steps are: they are computed again
  /// when they are needed. A step then takes 24 bytes per dof, and one that changes the mesh about
  /// 100 bytes more per triangle, 150 for each linear load, and 30 kB per face.
  size_t history_bytes = size_t(512) << 20;
  /// Number n of facet edges per triangle edge in frames; each triangle is displayed as n² facets.
  int facets_per_edge = 2;
};

}  // namespace batten
