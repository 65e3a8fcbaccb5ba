// Solves the shape of a model under all loads and constraints of a scene.
#pragma once

#include <memory>
#include <vector>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/shapes/fair_shape.h"

namespace batten {

// Fair shape of a scene's lines, which is also the rest shape of its session.

/// True if the scene's lines get another shape than the one of minimum bending: because of [skin]
/// fair or a [[target]], or because its curves are a series of sections or bound regions with five
/// or more sides.
bool requests_fair_shape(const Scene& scene, const BuiltModel& made);

/// Reads the scene's targets, if any, and computes the shape that the scene requests, or that its
/// faces get automatically (skinning/shapes/fair_shape.h).
///
/// `bent`: dofs of the minimum-bending shape on `layout`, used as the start. Throws the exceptions
/// of target_of() and compute_fair_shape(), with the location in the scene.
FairShape compute_fair_shape(const Scene& scene, const BuiltModel& made,
                             std::shared_ptr<const ModelLayout> layout, const Points& bent,
                             const Progress& progress = {});

/// Dofs of the minimum-bending shape of a scene's lines and material on a layout.
Points min_bending_shape(const ModelLayout& layout, const Scene& scene,
                         const Progress& progress = {});

/// Pointers to regions, as writers and pictures take them.
std::vector<const SkinnedRegion*> pointers(const std::vector<SkinnedRegion>& regions);

/// The solved shape of a model, with the measurements of its session.
struct SolvedShape {
  std::shared_ptr<const ModelLayout> layout;
  Points dofs;
  Points unloaded;                     ///< dofs of the shape of the lines alone, on the same layout
  std::vector<SkinnedRegion> regions;  ///< regions of the layout; moves of lines are applied
  SurfaceEnergy energy;
  int iterations = 0;
  double last_change = 0, max_constraint_residual = 0;
  double max_normal_constraint_deg = 0;  ///< largest error of normals prescribed by [[constraint]]
  std::vector<Reaction> reactions;
  std::vector<PointCloudDistances> scans;
  bool joins_planned = false;  ///< SolveReport::joins_planned
  FairingSummary fairing;      ///< set if the scene requests a fair shape

  std::vector<const SkinnedRegion*> all() const { return pointers(regions); }
};

/// The current shape of a session. `unloaded`: dofs of the unloaded surface on its layout.
/// `report`: result of the last solve_to_equilibrium().
SolvedShape shape_of(const SculptingSession& session, const Scene& scene, const Points& unloaded,
                     const SolveReport& report);

/// Solves the shape of a layout under a scene's constraints, loads and material. A fair shape, if
/// requested, is the rest shape. Throws ConflictError, NoSolutionError, InputError, CancelledError.
SolvedShape solve_shape(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                        const Progress& progress = {});

/// Solves the shape like solve_shape(), on the model's own layout. Triangles are bisected where
/// loads, moves and constraints pull the surface off its embedded lines, until the gaps are within
/// the tolerance or bisection no longer helps. A network without loads and constraints is already
/// solved.
SolvedShape solve_refined_shape(const BuiltModel& made, const Scene& scene,
                                const Progress& progress = {});

/// The refined layout of solve_refined_shape() for the scene's values, for use in a session. If
/// these have no solution, it is the last layout reached.
ModelLayout refine_for_lines(const BuiltModel& made, const Scene& scene,
                             const Progress& progress = {});

/// A model, with the layout and rest shape for its sessions.
struct SculptModel {
  BuiltModel made;
  std::shared_ptr<const ModelLayout> layout;  ///< refined layout (refine_for_lines() or fair shape)
  FairShape fair;                             ///< set if the scene requests it
};
/// Prepares a model for sessions. Throws the exceptions of solve_refined_shape(), and InputError if
/// no region has a surface.
SculptModel sculpt_model(BuiltModel made, const Scene& scene, const Progress& progress = {});

/// Stores the shape in the model and measures its quality.
void set_shape(BuiltModel& made, const SolvedShape& shape, const Progress& progress = {});

}  // namespace batten
