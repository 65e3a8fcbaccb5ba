// Surfaces of least curvature: ∫ κ1² + κ2² dA over C1 triangles, held by linear constraints.
#pragma once

#include "batten/constraints/constraint_set.h"
#include "batten/fem/surface.h"

namespace batten {

/// ∫ κ1² + κ2² dA, a pure number: it depends on the shape alone, not on its size, place or
/// parameter. 0: a plane (or any surface flat everywhere); 2 A/R² on a sphere of radius R, 8π on
/// the whole one. It is 4∫H² dA - 2∫K dA, and where the boundary and the normals along it are given
/// ∫K is fixed too (Gauss, Bonnet): then it has the minima of the Willmore energy ∫H² dA.
///
/// Computed by C1Triangle::default_quadrature: degree 4 on the thirds of HCT triangles, six-Duffy on Z12.
/// Infinite where x_u × x_v vanishes. `gradient`, when given: derivative with respect to the dofs,
/// n×3.
double curvature_functional(const Surface& surface, Points* gradient = nullptr);

struct SurfaceCurvatureOptions {
  /// Weight, above 0, of ∬ |tangential part of the change of X_uu, X_uv, X_vv|² du dv in a round,
  /// made free of unit by the areas of domain and start. The functional leaves free how (u, v) runs
  /// over the shape; this keeps it where the start has it. 0.1 to 0.001: larger ones take more
  /// rounds, smaller ones more iterations.
  double parametrization_weight = 1e-2;
  /// Done when a round lowers the functional by less than this part of it.
  double tolerance = 1e-6;
  int max_rounds = 20;
  int max_iterations = 300;  ///< iterations of all rounds together
};

struct SurfaceCurvatureResult {
  Points dofs;                  ///< n×3
  double functional = 0;        ///< functional of this surface
  double start_functional = 0;  ///< functional of the start, moved to meet the constraints
  double max_residual = 0;      ///< largest violation of a constraint, model units
  int iterations = 0, rounds = 0;
  bool converged = false;
};

/// Minimises the functional over the dofs that meet the constraints, downhill from `start` (its
/// free dofs; the others follow). Boundary curves and normals are rows of SurfaceConstraints; a good
/// start is the surface of least linear bending under the same rows.
///
/// Rounds of Levenberg and Marquardt's method on the residuals √dA (S11, √2 S12, S22), S the shape
/// operator in an orthonormal frame at the quadrature points, with the linear bending energy as
/// damping and sparse Cholesky. Each round adds the weight on tangential change against the surface
/// it began with: where rounds stand still, that term is zero, and the shape owes it nothing. Needs
/// no Ceres.
///
/// Throws InputError: options that are not above 0, constraints for another mesh, a start without
/// area or without normal somewhere; ConflictError: contradicting constraints; NoSolutionError:
/// constraints that leave the surface free to move away. Cost: tens of iterations of about 0.1 ms
/// a triangle (HCT; Z12 1 ms).
SurfaceCurvatureResult fair_curvature(const Surface& start, const ConstraintSet& constraints,
                                      const SurfaceCurvatureOptions& options = {});

}  // namespace batten
