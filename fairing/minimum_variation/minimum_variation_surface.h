// SPDX-License-Identifier: MPL-2.0
// Minimum-variation surfaces (MVS): fair surfaces that are determined by their boundary curves.
#pragma once

#include <limits>
#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/core/progress.h"
#include "batten/fairing/minimum_variation/curvature_variation.h"
#include "batten/fem/surface.h"

namespace batten {

/// Options of minimize_curvature_variation().
struct MinimumVariationOptions {
  /// Weight of K² (K: Gaussian curvature) relative to the weight of the curvature variation.
  /// Default 1e-3. For annular domains, use 100: it selects the cylinder or cone among all
  /// barrel-shaped surfaces of zero curvature variation.
  double gauss = 1e-3;
  /// Weight of curvature jumps across element edges; values from 0.2 to 20 give the same shapes.
  double jumps = 2;
  /// Sides of the boundary, each given by its vertices in order, from corner to corner. The twist,
  /// that is the rotation of the surface normal about the tangent of a side, per length, is
  /// penalised along sides of constant curvature if the rotation along the whole side is nearly
  /// zero or a multiple of 360°. The penalty distinguishes a torus from similar surfaces with the
  /// same boundary. Empty: no penalty.
  std::vector<std::vector<int>> sides;
  /// Points along smooth joins at which jumps of curvature are penalised, as across element edges.
  /// Empty: the curvature may jump, as between a cap and a cylinder.
  std::vector<JoinPoint> joins;
  /// One flag per triangle: 1 if the triangle keeps its shape and contributes nothing to the
  /// functional. Empty: no triangle.
  std::vector<char> frozen;
  /// Dofs of alternative starting surfaces; the minimisation begins at the one with the smallest
  /// functional. Empty: the minimisation begins at the given `start`.
  std::vector<Points> starts;
  int max_iterations = 40;
  /// `strength`: fraction of the displacement from `start` to the minimum that is applied, above 0,
  /// at most 1. `largest_move`: upper limit of the displacement of any vertex along the normal,
  /// model units. Constraints are satisfied for every fraction.
  double strength = 1, largest_move = std::numeric_limits<double>::infinity();
};

/// Result of minimize_curvature_variation().
struct MinimumVariationSurface {
  Points dofs;                  ///< dofs of the surface, n×3
  double fraction = 1;          ///< applied fraction of the displacement from start to minimum
  double functional = 0;        ///< minimised functional at `dofs`, 1/length²
  double start_functional = 0;  ///< minimised functional at the start, 1/length²
  /// Maximum displacement of a vertex along the normal of the starting surface, model units.
  double max_move = 0;
  double max_residual = 0;  ///< maximum violation of a constraint, model units
  int iterations = 0;       ///< number of accepted Gauss-Newton steps
  int factorizations = 0;
  /// True if the last step hardly moved the shape, if no step can reduce the functional by 3 %, or
  /// if two consecutive steps reduced it by less than 3 %.
  bool converged = false;
};

/// Computes a minimum-variation surface [MoretonSequin1992]: minimises the variation of curvature
/// over the dofs that satisfy the constraints.
///
/// The functional is minimised from `start`; strength and displacements are measured from there:
///
///     E = ∫ (change of curvature)² dA + jumps · Σ_edges ∫ (jump of curvature)²/h ds + twist
///
/// The first term is that of curvature_variation_residuals(). It vanishes on spheres, cylinders,
/// cones and tori (Dupin cyclides), so their boundary curves alone reproduce these shapes. Elements
/// are C1, and their third derivatives exist only inside the thirds of HCT triangles. The jumps
/// across edges and spokes complete them, as in interior penalty methods.
///
/// Uses Gauss-Newton steps in principal frames that are kept constant during a step. Tangential
/// changes are damped relative to the current surface, so the damping does not affect the final
/// shape. Measurements: docs/fairness.md.
///
/// Throws InputError for a Z12 surface, for constraints on another mesh, and for a start of zero
/// area or without a normal at some point. Also throws ConflictError for contradictory constraints,
/// NoSolutionError for a singular system, and CancelledError. Cost: 4 to 15 factorizations of a
/// system with the unknowns of all three coordinates.
MinimumVariationSurface minimize_curvature_variation(const Surface& start,
                                                     const ConstraintSet& constraints,
                                                     const MinimumVariationOptions& options = {},
                                                     const Progress& progress = {});

}  // namespace batten
