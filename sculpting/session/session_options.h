// Options of a session and of the motion of its surface.
#pragma once

#include <cstddef>

#include "batten/core/expected.h"
#include "batten/elements/surface_stiffness.h"
#include "batten/skinning/model/model_scale.h"

namespace batten {

/// The surface moves by M (ρ ẍ + μ ẋ) + K x = F (constraints/implicit_steps.h).
struct Motion {
  double dt = 0;       ///< length of a step in time, > 0
  double density = 1;  ///< ρ ≥ 0; not both 0
  double damping = 1;  ///< μ ≥ 0
  double theta = 1;    ///< θ of the implicit steps, ½ … 1
};

/// How a session is made.
struct SessionOptions {
  SurfaceStiffness material;  ///< the parameters alpha and beta (or alpha_uu, … beta_vv) start here
  bool isotropic_alpha = true, isotropic_beta = true;  ///< one parameter each, or three
  LoadUnits units = LoadUnits::Relative;
  bool hold_corners = false;  ///< holds the corners only, instead of the lines
  /// one_factor: the session settles once or twice, and a better order of its factor would not pay.
  Expected expected = Expected::many_factors;
  /// settle() has converged when no dof inside moves by more than this times the size in one
  /// iteration (slopes count times the size of their triangles). It has converged too when the
  /// largest move is below 1e-9 of the size and does not fall any more.
  double tolerance = 1e-12;
  int most_iterations = 60;
  /// The history keeps states and factors of up to this many bytes, at least one step and at most
  /// 256.
  size_t history_bytes = size_t(512) << 20;
  int facets_per_edge = 2;  ///< in frames: n² facets for each triangle
};

}  // namespace batten
