// From a model to its shape: everything that a scene has act on it.
#pragma once

#include <memory>
#include <vector>

#include "batten/apps/commands/shapes/make_model.h"
#include "batten/sculpting/session/session.h"

namespace batten {

/// As writers and pictures take regions.
std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions);

/// A finished shape of a model, and what its session knew of it.
struct MadeShape {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
  Points unloaded;                     ///< what the lines alone make, on the same layout
  std::vector<SkinnedRegion> regions;  ///< of the layout, with lines as they are moved
  SurfaceEnergy energy;
  int iterations = 0;
  double last_change = 0, max_constraint_residual = 0;
  double max_normal_constraint_deg = 0;  ///< at the places that a [[constraint]] holds
  std::vector<Reaction> reactions;
  std::vector<ScanDistances> scans;
  bool joins_planned = false;  ///< Answer::joins_planned

  std::vector<const SkinnedRegion*> all() const { return pointers(regions); }
};

/// The session's shape as it is. `unloaded`: dofs on its layout. `answer`: of the last settle().
MadeShape shape_of(const SculptingSession& session, const Scene& scene, const Points& unloaded,
                   const Answer& answer);

/// The shape that a scene's constraints, loads and material make of a layout: a session that
/// settles. Throws ConflictError, NoSolutionError, InputError, CancelledError.
MadeShape make_shape(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                     const Progress& progress = {});

/// The same of the model's own layout, halving triangles where loads, moves and constraints pull
/// the surface off its embedded lines, until it keeps the tolerance there or halving helps no more.
/// A network on which nothing acts has its shape already.
MadeShape make_refined_shape(const MadeModel& made, const Scene& scene,
                             const Progress& progress = {});

/// The layout of make_refined_shape(), for a session of the scene's own values; the model's where
/// these have no solution.
ModelLayout refined_for_lines(const MadeModel& made, const Scene& scene,
                              const Progress& progress = {});

/// Puts the shape into the model, measured.
void take_shape(MadeModel& made, const MadeShape& shape, const Progress& progress = {});

}  // namespace batten
