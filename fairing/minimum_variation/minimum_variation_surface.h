// Surfaces whose curvature changes least: fair surfaces from their lines alone.
#pragma once

#include <limits>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/fairing/minimum_variation/join_point.h"
#include "batten/fem/surface.h"

namespace batten {

struct MinimumVariationOptions {
  /// Weight of K² over that of the change of curvature. 1e-3; between two rims 100, which makes a
  /// cylinder or cone of all the barrels that change nothing.
  double gauss = 1e-3;
  /// Weight of the jumps of curvature across element edges; 0.2 to 20 give the same shapes.
  double jumps = 2;
  /// Vertices of each side of the outline in order, from corner to corner. Along sides whose
  /// normals do not turn about them, and whose curvature is constant, twist is resisted: this tells
  /// a torus from its neighbours. None: no such term.
  std::vector<std::vector<int>> sides;
  /// Points of smooth joins across which curvature goes on: there its jump counts as across element
  /// edges. None: it may jump, as between a cap and a cylinder.
  std::vector<JoinPoint> joins;
  /// By triangle: those that keep their shape and count nothing. Empty: none.
  std::vector<char> frozen;
  /// Dofs of surfaces to go downhill from: the one that costs least is taken. None: the start.
  std::vector<Points> starts;
  int max_iterations = 40;
  /// How much of the way from the start to the result is gone, 0 to 1, and the largest move of a
  /// vertex along the normal, model units. Every row holds on all of the way.
  double strength = 1, largest_move = std::numeric_limits<double>::infinity();
};

struct MinimumVariationSurface {
  Points dofs;                  ///< n×3
  double fraction = 1;          ///< of the way from the start that was gone
  double functional = 0;        ///< E of this surface, 1/length²
  double start_functional = 0;  ///< E of the start
  double max_move = 0;          ///< largest move of a vertex along the start's normal, model units
  double max_residual = 0;      ///< largest violation of a constraint, model units
  int iterations = 0;           ///< steps that were taken
  int factorizations = 0;
  /// The last step hardly moved the shape, or no step gains three hundredths of the functional, or
  /// two in a row did not.
  bool converged = false;
};

/// Minimises over the dofs that meet the constraints, downhill from `start` (moves and strength are
/// measured from it):
///
///     E = ∫ (change of curvature)² dA + jumps · Σ_edges ∫ (jump of curvature)²/h ds + twist
///
/// The first term is that of curvature_variation_residuals(): it vanishes on spheres, cylinders, cones and tori
/// (Dupin cyclides), so that their boundary lines alone give these shapes. Elements are C1 and
/// their third derivatives live inside the thirds of HCT triangles; jumps across edges and spokes
/// complete them, as in interior penalty methods. Source: Moreton, Sequin 1992.
///
/// Gauss-Newton steps in principal frames that stand still during a step. Tangential change is
/// damped about the present surface and so leaves no trace in the shape.
/// docs/fairness.md has the measurements.
///
/// Throws InputError: a Z12 surface, constraints for another mesh, a start without area or without
/// normal somewhere; ConflictError; NoSolutionError; CancelledError. Cost: 4 to 15 factorizations
/// of three times as many unknowns as one coordinate has.
MinimumVariationSurface minimize_curvature_variation(const Surface& start,
                                                     const ConstraintSet& constraints,
                                                     const MinimumVariationOptions& options = {},
                                                     const Progress& progress = {});

}  // namespace batten
