// Options of a session and of the motion of its surface.
#pragma once

#include <cstddef>
#include <functional>

#include "batten/constraints/constraint_set.h"
#include "batten/core/solvers/symbolic_analysis.h"
#include "batten/core/progress.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// The surface moves by M (ρ ẍ + μ ẋ) + K x = F (constraints/theta_integrator.h).
struct Motion {
  double dt = 0;       ///< length of a step in time, > 0
  double density = 1;  ///< ρ ≥ 0; not both 0
  double damping = 1;  ///< μ ≥ 0
  double theta = 1;    ///< θ of the implicit steps, ½ … 1
};

/// What a rest shape is made from. All dofs are in absolute coordinates.
struct RestShapeInput {
  const ModelLayout& layout;
  const ConstraintSet& rows;  ///< of lines, moves and constraints, as they are now
  const Points& bent;         ///< the shape that bends least under these rows
  /// The shape under these rows that bends least from the first rest shape on this mesh: near to
  /// what is wanted, and the same whichever way the rows came here. No rows: this is the first.
  const Points& near;
  const Progress& progress;
};

/// Makes the rest shape of a session: the one without elastic energy, from which loads, moves and
/// constraints bend the surface. It need not meet the rows. A result without rows: there is none,
/// and lines bend the surface from nothing.
using RestShapeFunction = std::function<Points(const RestShapeInput&)>;

/// How a session is made.
struct SessionOptions {
  SurfaceStiffness material;  ///< the parameters alpha and beta (or alpha_uu, … beta_vv) start here
  bool isotropic_alpha = true, isotropic_beta = true;  ///< one parameter each, or three
  LoadUnits units = LoadUnits::Relative;
  bool fix_corners_only = false;  ///< holds the corners only, instead of the lines
  /// Called by settle() where rows are others than when it was called before; answers in between
  /// are linear. Empty: none. docs/fairness.md.
  RestShapeFunction rest;
  /// once: the session settles once or twice, and a better order of its factor would not pay.
  FactorReuse factor_reuse = FactorReuse::many;
  /// settle() has converged when no dof inside moves by more than this times the size in one
  /// iteration (slopes count times the size of their triangles). It has converged too when the
  /// largest move is below 1e-9 of the size and does not fall any more.
  double tolerance = 1e-12;
  int max_iterations = 60;
  /// The history keeps states and factors of up to this many bytes, at least one step and at most
  /// 256.
  size_t history_bytes = size_t(512) << 20;
  int facets_per_edge = 2;  ///< in frames: n² facets for each triangle
};

}  // namespace batten
