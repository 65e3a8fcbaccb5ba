// Makes the shape of a model under everything that a scene has act on it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/fair_shape.h"
#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

/// Pointers to regions, which writers and pictures take.
std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions);

/// A finished shape of a model, and what its session measured.
struct SolvedShape {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
  Points unloaded;                     ///< dofs of what the lines alone make, on the same layout
  std::vector<SkinnedRegion> regions;  ///< the layout's regions, with lines where moves put them
  SurfaceEnergy energy;
  int iterations = 0;
  double last_change = 0, max_constraint_residual = 0;
  double max_normal_constraint_deg = 0;  ///< largest error of normals that [[constraint]] holds
  std::vector<Reaction> reactions;
  std::vector<ScanDistances> scans;
  bool joins_planned = false;  ///< Answer::joins_planned
  FairingSummary fairing;      ///< where the scene asks for a fair shape

  std::vector<const SkinnedRegion*> all() const { return pointers(regions); }
};

/// The session's present shape. `unloaded`: dofs of the unloaded surface on its layout. `report`:
/// what the last solve_to_equilibrium() returned.
SolvedShape shape_of(const SculptingSession& session, const Scene& scene, const Points& unloaded,
                     const SolveReport& report);

/// Makes the shape of a layout under a scene's constraints, loads and material: a session settles
/// once. Where the scene asks for a fair shape, that is what its session bends. Throws
/// ConflictError, NoSolutionError, InputError, CancelledError.
SolvedShape solve_shape(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                        const Progress& progress = {});

/// Makes the shape of the model's own layout in the same way. Triangles are halved where loads,
/// moves and constraints pull the surface off its embedded lines, until gaps are within the
/// tolerance or halving does not help. A network on which nothing acts has its shape already.
SolvedShape solve_refined_shape(const BuiltModel& made, const Scene& scene,
                                const Progress& progress = {});

/// The layout that solve_refined_shape() reaches for the scene's own values, for a session. Where
/// these have no solution, it is the layout reached so far.
ModelLayout refine_for_lines(const BuiltModel& made, const Scene& scene,
                             const Progress& progress = {});

/// A model and what its sessions are made on.
struct SculptModel {
  BuiltModel made;
  std::shared_ptr<const ModelLayout> layout;  ///< refine_for_lines(), or that of the fair shape
  FairShape fair;                             ///< where the scene asks for one
};
/// Throws as solve_refined_shape(), and InputError where no region is skinned.
SculptModel sculpt_model(BuiltModel made, const Scene& scene, const Progress& progress = {});

/// Puts the shape into the model and measures its quality.
void set_shape(BuiltModel& made, const SolvedShape& shape, const Progress& progress = {});

}  // namespace batten
