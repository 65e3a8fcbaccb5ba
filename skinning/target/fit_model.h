// Fits the shape of a model to a target surface; its lines stay fixed.
#pragma once

#include <memory>

#include "batten/core/progress.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// Options of fit_model().
struct ModelFitOptions {
  double tolerance = 0;  ///< accepted distance, model units; 0: 1e-4 of the model's size
  int max_rounds = 12;   ///< fixed-point iterations per mesh at the smallest ε
  /// Largest number of mesh refinements.
  int max_refinements = 5;
  /// Largest number of triangles of the model after refinement.
  int max_triangles = 60'000;
  /// Parts of the target. A region whose lines all lie on one part is fitted to that part only.
  std::vector<std::shared_ptr<const TargetSurface>> parts = {};
};

/// A model fitted to its target, and its distances.
struct ModelFit {
  std::shared_ptr<const ModelLayout> layout;  ///< the given layout, or a refined one
  /// Absolute dofs of the fitted shape on `layout`.
  Points dofs;
  int iterations = 0;
  int refinements = 0;
  TargetDistances before, after;
  bool reached = false;  ///< true if after.largest() ≤ tolerance
};

/// Computes the shape that satisfies the constraints C x = c of the model's lines and smooth joins
/// and is nearest to the target, by fixed-point iteration. In each iteration the surface is
/// attracted along its normal n to the tangent plane of the target at the closest point t, with
/// normal m. So it can slide along the target:
///
///     g = n ((t - x)·m) / (n·m)
///     minimise ∫ |x' - x - g|² + ε h⁴ ∫ |∂²x'|²   subject to the constraints,
///
/// where h is the size of a triangle on the model scaled to size 1. The bending term distributes
/// the parametrisation over the surface, so that it does not fold, and smooths it. ε falls from 100
/// to 1, 0.03 and 1e-3, with some iterations each, until the surface is within half the tolerance.
/// If none of them suffices, ε ends at 1e-5, which displaces the shape by less than the
/// discretisation error.
///
/// A region with its own part of the target starts with g = t(u, v) - x if it is far away or its
/// lines gave a poor domain. Here t(u, v) are the part's points over its domain
/// (TargetSurface::parametrize()); closest points would fail in pockets that are deeper than wide.
/// Triangles that nevertheless become inverted relative to the target, and those around them, get a
/// hundred times the bending term. Beyond the boundary of the target there is no attraction.
///
/// The matrix, mass + ε h⁴ bending, is constant while ε and the constraints are: one factorization
/// serves many iterations. Anderson acceleration [Anderson1965] reduces their number.
///
/// Triangles are bisected for one of three reasons: a distance in either direction exceeds the
/// tolerance; an embedded line has a gap above its own tolerance; the normal varies by more than
/// 75° within the triangle. Then smooth joins are planned anew and iterations continue, as long as
/// that helps. Triangles are not refined where the lines themselves are that far from the target.
///
/// `start`: absolute dofs on the layout that satisfy its lines, close enough to the target for
/// closest points to be meaningful. Throws InputError for a negative tolerance or a target without
/// any point nearby; ConflictError, NoSolutionError, CancelledError. Cost: one factorization per ε,
/// refinement and new plan of joins; 18 closest-point queries per iteration and triangle.
ModelFit fit_model(std::shared_ptr<const ModelLayout> layout, const Points& start,
                   const TargetSurface& target, const ModelFitOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
