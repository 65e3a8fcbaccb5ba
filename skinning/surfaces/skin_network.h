// Makes a surface model of all regions of a curve network, reshapes it and fairs it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Skins all regions of a network and joins them to one model.
///
/// 1. Orient the regions: normals agree across edges, and point outwards if a shell is closed.
/// 2. Lay out each region (RegionLayout) on the curves of its edges, with the same vertices on both
///    sides of an edge, and solve it on its own. All edges are creases at this stage.
/// 3. Classify the edges as creases or smooth joins (JoinSpec, or the angle found). At a node where
///    the tangents of both sides do not lie in one plane, a smooth join ends as a crease, with a
///    warning.
/// 4. Solve regions connected by smooth joins together (model/join.h). Halve mesh edges along joins
///    until they meet the tolerance. A join on an embedded line becomes a crease if more than 0.5°
///    would remain.
/// 5. Measure the model and find its defects.
///
/// A region that cannot be skinned is left out (ModelRegion::rejection_reason); the others are
/// made. Throws InputError if a specification fits nothing, NoSolutionError, CancelledError.
SurfaceModel skin_network(const CurveNetwork& network, const FoundRegions& found,
                          const ModelOptions& options = {}, const Progress& progress = {});

/// Gives a model the shape of a session, measures it again and finds its defects.
///
/// `layout`: a layout of the same regions, possibly with finer meshes. `dofs`: the shape on it.
/// `made`: its regions, in order. Joins that the layout has rejected meanwhile become creases.
void reshape(SurfaceModel& model, std::shared_ptr<const ModelLayout> layout, Points dofs,
             std::vector<SkinnedRegion> made, const Progress& progress = {});

// Fairing of a model without introducing defects.

/// A region that was not faired.
struct UnchangedRegion {
  int region = 0;   ///< index into the regions of the layout
  std::string why;  ///< a sentence for the user
};

/// Result of fair_model().
struct FairingResult {
  std::shared_ptr<const ModelLayout> layout;
  MinimumVariationSurface surface;  ///< faired shape, dofs on `layout`
  std::vector<UnchangedRegion> unchanged_regions;
};

/// Fairs a model: minimises the variation of curvature (fair_shape()) subject to the line
/// constraints of the model.
///
/// `layout`: has the regions of the model. `start`: dofs on `layout`, from which the functional
/// decreases. `max_join_angle_deg`: tolerance of smooth joins. `only`: for each region of the
/// layout, whether it is faired; the others keep their shape and are not listed in
/// FairingResult::unchanged_regions. Empty: all are faired.
///
/// A region keeps its shape if it is inverted, because curvature is meaningless there. It also does
/// if fairing would introduce a defect; the others are then faired again.
///
/// Rounder surfaces meet at larger angles between the nodes of smooth joins, and leave embedded
/// lines between their points. If these errors exceed `max_join_angle_deg` or the tolerance of the
/// lines, triangles are halved, joins on embedded lines are planned again, and fairing continues,
/// at most three times. A refinement that makes the model worse is undone. A region in which only
/// the finer mesh causes a defect keeps its shape, too.
///
/// Throws as fair_shape(); NoSolutionError if no region is left to be faired.
FairingResult fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                         const Points& start, double max_join_angle_deg,
                         const MinimumVariationOptions& options = {}, const Progress& progress = {},
                         const std::vector<char>& only = {});

}  // namespace batten
