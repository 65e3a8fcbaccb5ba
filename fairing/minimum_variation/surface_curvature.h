// SPDX-License-Identifier: MPL-2.0
// Fairing of surfaces by minimising ∫ κ1² + κ2² dA (a Willmore-type energy) over C1 triangles under
// linear constraints.
#pragma once

#include "batten/constraints/constraint_set.h"
#include "batten/fem/surface.h"

namespace batten {

/// Computes ∫ κ1² + κ2² dA of a surface with the principal curvatures κ1, κ2: a dimensionless
/// number that depends on the shape only, not on size, position or parametrisation.
///
/// It is 0 for a plane, 2 A/R² for a part of area A of a sphere of radius R, and 8π for the whole
/// sphere. It equals 4∫H² dA - 2∫K dA with the mean curvature H and the Gaussian curvature K. If
/// the boundary and the normals along it are given, ∫K is fixed as well (Gauss-Bonnet). Then the
/// minima are those of the Willmore energy ∫H² dA.
///
/// The quadrature is that of C1Triangle::default_quadrature: degree 4 on the thirds of HCT
/// triangles, the six-Duffy rule on Z12. The result is infinite if x_u × x_v vanishes. `gradient`,
/// if given: set to the derivative with respect to the dofs, n×3.
double curvature_functional(const Surface& surface, Points* gradient = nullptr);

/// Options of fair_curvature() for surfaces.
struct SurfaceCurvatureOptions {
  /// Weight, above 0, of the penalty ∬ |tangential part of the change of X_uu, X_uv, X_vv|² du dv,
  /// made dimensionless by the areas of the domain and the starting surface. The change is measured
  /// from the beginning of each round (outer iteration). The minimised functional does not depend
  /// on the parametrisation; the penalty keeps the parametrisation close to that of the start. Use
  /// 0.1 to 0.001: larger values require more rounds, smaller values more Levenberg-Marquardt
  /// iterations per round.
  double parametrization_weight = 1e-2;
  /// The minimisation has converged if a round decreases curvature_functional() by less than this
  /// fraction.
  double tolerance = 1e-6;
  int max_rounds = 20;  ///< maximum number of rounds
  /// Maximum number of Levenberg-Marquardt iterations, summed over all rounds.
  int max_iterations = 300;
};

/// Result of fair_curvature() for surfaces.
struct SurfaceCurvatureResult {
  Points dofs;            ///< dofs of the surface, n×3
  double functional = 0;  ///< curvature_functional() of the result
  /// Value of curvature_functional() for the start projected onto the constraints.
  double start_functional = 0;
  double max_residual = 0;         ///< maximum violation of a constraint, model units
  int iterations = 0, rounds = 0;  ///< number of iterations of all rounds together, and of rounds
  bool converged = false;
};

/// Minimises curvature_functional() over the dofs that satisfy the constraints, from `start` to a
/// local minimum.
///
/// Only the free dofs of `start` are used; the others follow from the constraints. Boundary curves
/// and normals are imposed by SurfaceConstraints. A good start is the surface of least linear
/// bending under the same constraints.
///
/// The minimisation consists of rounds (outer iterations). Each round uses Levenberg-Marquardt
/// iterations on the residuals √dA (S11, √2 S12, S22), with the shape operator S in an orthonormal
/// frame at the quadrature points. The linear bending energy serves as damping; the solver is
/// sparse Cholesky. Each round penalises tangential change relative to the surface at the beginning
/// of the round. At convergence, this term is zero and does not affect the shape. Does not need
/// Ceres.
///
/// Throws InputError for options that are not above 0, for constraints on another mesh, and for a
/// start of zero area or without a normal at some point. Throws ConflictError for contradictory
/// constraints and NoSolutionError if the constraints leave the surface free to move. Cost: tens of
/// iterations of about 0.1 ms per HCT triangle or 1 ms per Z12 triangle.
SurfaceCurvatureResult fair_curvature(const Surface& start, const ConstraintSet& constraints,
                                      const SurfaceCurvatureOptions& options = {});

}  // namespace batten
