// Fits the shape of a model to a given surface; its lines are kept.
#pragma once

#include <memory>

#include "batten/core/progress.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

struct ModelFitOptions {
  double tolerance = 0;  ///< wanted distance, model units; 0: 1e-4 of the model's size
  int max_rounds = 12;   ///< on one mesh, once its first shape is near
  int max_refinements = 5;
  int max_triangles = 60'000;
  /// Parts of the target: a region whose lines all lie on one of them is drawn to that part alone.
  std::vector<std::shared_ptr<const TargetSurface>> parts = {};
};

/// A model at its target, and how near it came.
struct ModelFit {
  std::shared_ptr<const ModelLayout> layout;  ///< the one given, or a finer one
  Points dofs;
  int iterations = 0;
  int refinements = 0;
  TargetDistances before, after;
  bool reached = false;  ///< whether after.largest() ≤ tolerance
};

/// The shape that has the model's lines (rows C x = c, and those of smooth joins) and is nearest to the
/// target. In each round springs reach from every point of the surface, along its normal n, to the plane
/// that touches the target at the nearest point t with normal m, so that it may slide:
///
///     g = n ((t - x)·m) / (n·m)
///     minimise ∫ |x' - x - g|² + ε h⁴ ∫ |∂²x'|²   under the rows,
///
/// h the size of a triangle on the model scaled to size 1. The second term spreads the parameters over the
/// surface, so that it does not fold, and makes it fair: ε falls from 100 to 1, 0.03 and 1e-3, some rounds
/// each, until the surface is within half the tolerance; where none of these is, it is 1e-5 at the end, which
/// draws the shape aside by less than triangles miss it anyway. A region that has a part of its own begins with
/// g = t(u, v) - x, t the part's points over its domain (TargetSurface::parametrize), if it is far away or its
/// lines made no good domain: nearest points would not lead into what is deeper than wide. Triangles that look
/// away from the target nevertheless, and those around them, keep a hundred times as much bending. The matrix,
/// mass + ε h⁴ bending, stays the same while ε and rows do: one factor, many rounds, which Acceleration makes
/// fewer. Beyond the target's rim springs have no pull. Where the target is still farther than the tolerance,
/// either way, or an embedded line has a gap above its own, triangles there are halved, and those that turn by
/// more than 75° within themselves; smooth joins are planned anew, and rounds go on, as long as that helps; not
/// where lines themselves are that far away.
///
/// `start`: absolute dofs on the layout that have its lines, near enough to the target that nearest points
/// are the right ones. Throws InputError: a tolerance below 0, or a target without any point near;
/// ConflictError, NoSolutionError, CancelledError. Costs a factor for each ε, halving and new plan of joins, and for
/// each round and triangle 18 nearest points.
ModelFit fit_model(std::shared_ptr<const ModelLayout> layout, const Points& start,
                   const TargetSurface& target, const ModelFitOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
