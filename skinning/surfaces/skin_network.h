// Makes one model of the regions of a network, and gives it another shape.
#pragma once

#include <memory>
#include <vector>
#include <string>

#include "batten/core/progress.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {

/// Skins all regions of a network.
///
/// 1. Regions get normals that agree across arcs, outwards where a shell is closed.
/// 2. Each is laid out (RegionLayout) on the arcs' own curves, with the same vertices on both
///    sides of an arc, and solved by itself: all lines are creases.
/// 3. Arcs become creases or smooth joins (JoinSpec, or the angle found). At a node where the
///    tangents of both sides do not lie in one plane a smooth join ends in a crease, with a
///    warning.
/// 4. Regions that smooth joins connect are solved together (model/join.h), and halved along joins
///    until these keep the tolerance. A join that a region carries embedded, and that would be left
///    with more than half a degree, becomes a crease.
/// 5. The model is measured, and its flaws are looked for.
///
/// A region that cannot be skinned is left out (ModelRegion::rejection_reason); the others are made all the
/// same.
/// Throws InputError for words that fit nothing, NoSolutionError, CancelledError.
SurfaceModel skin_network(const CurveNetwork& network, const FoundRegions& found,
                          const ModelOptions& options = {}, const Progress& progress = {});

/// Gives a model another shape, that of a session; it is measured anew and its flaws are looked
/// for. `layout`: with the same regions (their meshes may be finer); `made`: its regions, in order.
/// Joins that were given up on the way become creases.
void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress = {});


// Fairs a model without making anything wrong.

/// A region that keeps the shape that it had.
struct UnchangedRegion {
  int region = 0;   ///< index into the regions of the layout
  std::string why;  ///< a sentence for the user
};

struct FairingResult {
  std::shared_ptr<const ModelLayout> layout;
  MinimumVariationSurface surface;  ///< on that layout
  std::vector<UnchangedRegion> unchanged_regions;
};

/// fair_shape() under the rows of the model's lines, downhill from `start`, dofs on `layout`, which
/// has the regions of the model.
///
/// A region keeps its shape where that turns over (curvature means nothing there), and where
/// fairing would give it a flaw that it did not have: then all others are faired again beside it.
/// Rounder surfaces meet at larger angles between the nodes of smooth joins, and leave embedded
/// lines between their points: where that is more than `max_join_angle_deg`, or the lines' tolerance,
/// triangles are halved and the model is faired on, three times at most, unless that spoils it.
/// Joins on embedded lines are planned again for that. A region that only the finer mesh gives a
/// flaw keeps its shape then, too.
///
/// `only`, by region of the layout: which are faired at all, the others keep their shape and are not in
/// FairingResult::unchanged_regions. Empty: all.
///
/// Throws as fair_shape(); NoSolutionError when no region is left.
FairingResult fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                         const Points& start, double max_join_angle_deg,
                         const MinimumVariationOptions& options = {}, const Progress& progress = {},
                         const std::vector<char>& only = {});

}  // namespace batten
