// How a session is made, and how its surface moves.
#pragma once

#include <cstddef>

#include "batten/core/expected.h"
#include "batten/elements/surface_stiffness.h"
#include "batten/skinning/model/model_scale.h"

namespace batten {

/// How a surface moves: M (ρ ẍ + μ ẋ) + K x = F (constraints/implicit_steps.h).
struct Motion {
  double dt = 0;       ///< > 0
  double density = 1;  ///< ρ ≥ 0
  double damping = 1;  ///< μ ≥ 0
  double theta = 1;    ///< ½ … 1
};

struct SessionOptions {
  SurfaceStiffness material;  ///< the parameters alpha and beta (or alpha_uu, … beta_vv) start here
  bool isotropic_alpha = true, isotropic_beta = true;  ///< one parameter each, or three
  LoadUnits units = LoadUnits::Relative;
  bool hold_corners = false;  ///< instead of the lines
  /// One: the session settles once or twice, and a better order of its factor would not pay.
  Expected expected = Expected::many_factors;
  /// Of settle(): converged when no dof inside moves by more than this times the size in one
  /// iteration (slopes times the size of their triangles), or by less than 1e-9 that does not fall
  /// any more.
  double tolerance = 1e-12;
  int most_iterations = 60;
  /// Undo keeps states and factors up to this many bytes, and at least one step.
  size_t history_bytes = size_t(512) << 20;
  int facets_per_edge = 2;  ///< of the frames
};

}  // namespace batten
