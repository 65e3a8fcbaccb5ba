// SPDX-License-Identifier: MPL-2.0
// Fits the shape of a model to a target surface. The curves of the model stay fixed.
#pragma once

#include <memory>

#include "batten/core/progress.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Options of fit_model().
struct ModelFitOptions {
  /// Accepted distance from the target, model units; 0: 1e-4 of the model size.
  double tolerance = 0;
  /// Largest number of iterations per mesh with the smallest weight ε of the bending term.
  int max_rounds = 12;
  /// Largest number of mesh refinements during the fit.
  int max_refinements = 5;
  /// Largest number of triangles of the model after refinement.
  int max_triangles = 60'000;
  /// Parts of the target, such as its CAD faces. A face of the model whose curves all lie on one
  /// part is fitted to that part only.
  std::vector<std::shared_ptr<const TargetSurface>> parts = {};
};

/// Result of fit_model(): the fitted model, and distances between model and target.
struct ModelFit {
  std::shared_ptr<const ModelLayout> layout;  ///< the given layout, or a refinement of it
  /// Absolute dofs of the fitted shape on `layout`.
  Points dofs;
  int iterations = 0;
  int refinements = 0;
  TargetDistances before, after;
  bool reached = false;  ///< true: after.largest() is at most the tolerance
  /// True if the target of each face is_analytic().
  bool analytic = false;
  /// The primitive of the target of each face; Kind::Free if it has none.
  std::vector<FittedPrimitive> primitives = {};
};

/// Computes the shape that satisfies the constraints C x = c of the model's curves and smooth joins
/// and is nearest to the target, by fixed-point iteration. In each iteration, each point x of the
/// surface is attracted along the surface normal n to the tangent plane of the target at the
/// closest point t, whose normal is m. The surface can therefore slide along the target. The new
/// surface x' is the solution of
///
///     g = n ((t - x)·m) / (n·m)
///     minimise ∫ |x' - x - g|² + ε h⁴ ∫ |∂²x'|²   subject to the constraints,
///
/// where h is the size of a triangle on the model scaled to size 1, and ε the weight of the bending
/// term. The bending term smooths the surface and distributes the parametrisation evenly, so that
/// the surface does not fold. ε decreases from 100 to 1, 0.03 and 1e-3, with several iterations per
/// value, until the surface is within half of the tolerance. If that is not reached, the last value
/// is ε = 1e-5, which displaces the shape by less than the discretisation error.
///
/// If a face is fitted to its own part of the target, and the face is far from that part or has a
/// poor domain, the first iterations use g = t(u, v) - x. Here, t(u, v) is the parametrization of
/// the part over the domain of the face (TargetSurface::parametrize()). Closest points would fail
/// in pockets that are deeper than wide. If triangles become inverted relative to the target, the
/// bending term of these and of adjacent triangles is multiplied by 100. There is no attraction
/// beyond the boundary of the target.
///
/// If the target of every face is a primitive (TargetSurface::primitive()), the shape is computed
/// without iterations: the initial shape is projected onto the primitives, and the projection is
/// interpolated (primitive_dofs()). Triangles are bisected until the distances are at most 0.05 of
/// the tolerance.
///
/// The system matrix (mass plus ε h⁴ times bending) changes only with ε, the mesh and the
/// constraints, so that one factorization is used for many iterations. Anderson acceleration
/// [Anderson1965] reduces the number of iterations.
///
/// Triangles are bisected for one of three reasons: a distance in either direction exceeds the
/// tolerance; an embedded curve has a gap above its own tolerance; the normal varies by more than
/// 75° within the triangle. Then the smooth joins are planned again, and the iterations continue as
/// long as the distances decrease. Triangles are not bisected for distances that the curves
/// themselves have from the target.
///
/// `start`: absolute dofs on the layout that satisfy the constraints of the curves. The start must
/// be close enough to the target for closest points to be meaningful. Throws InputError for a
/// negative tolerance or if the target has no point nearby; ConflictError; NoSolutionError;
/// CancelledError. Cost: one factorization per value of ε, per refinement and per new plan of
/// joins; 18 closest-point queries per triangle and iteration.
ModelFit fit_model(std::shared_ptr<const ModelLayout> layout, const Points& start,
                   const TargetSurface& target, const ModelFitOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
