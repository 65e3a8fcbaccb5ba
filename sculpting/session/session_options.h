// Options of a sculpting session, of its motion and of its rest shape.
#pragma once

#include <cstddef>
#include <functional>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/core/solvers/symbolic_analysis.h"
#include "batten/elements/reference_triangle.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

/// Parameters of the motion M (ρ ẍ + μ ẋ) + K x = F (constraints/theta_integrator.h).
struct Motion {
  double dt = 0;       ///< time step; > 0
  double density = 1;  ///< mass density ρ ≥ 0; ρ and μ must not both be 0
  double damping = 1;  ///< damping coefficient μ ≥ 0
  double theta = 1;    ///< parameter θ of the implicit scheme, ½ … 1
};

/// Input of a RestShapeFunction. All dofs are in absolute coordinates.
struct RestShapeInput {
  const ModelLayout& layout;
  const ConstraintSet& rows;  ///< current constraints of lines, offsets and others
  const Points& bent;         ///< the shape of least bending energy under these constraints
  /// The shape under these constraints that bends least from the first rest shape on this mesh. It
  /// is close to the desired shape and does not depend on the order of previous changes. No rows:
  /// this is the first call on this mesh.
  const Points& near;
  const Progress& progress;
};

/// Computes the rest shape of a session: the reference configuration of zero elastic energy, from
/// which loads, offsets and constraints bend the surface.
///
/// It need not satisfy the constraints. An empty result means that there is no rest shape: the
/// elastic energy is then that of the shape itself, as in thin-plate interpolation of the lines.
using RestShapeFunction = std::function<Points(const RestShapeInput&)>;

/// Options of a SculptingSession.
struct SessionOptions {
  SurfaceStiffness material;  ///< initial values of the parameters alpha and beta (or alpha_uu, …
                              ///< beta_vv)
  bool isotropic_alpha = true, isotropic_beta = true;  ///< true: one parameter (isotropic); false:
                                                       ///< three
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
  int facets_per_edge = 2;  ///< triangle edges are divided into n facets in frames: n² facets per
                            ///< triangle
};

}  // namespace batten
