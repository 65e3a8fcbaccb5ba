// Fairs a model without making anything wrong.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/skinning/model/fair_shape.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

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
