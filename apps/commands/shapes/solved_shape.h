// Makes the shape of a model under everything that a scene has act on it.
#pragma once

#include <memory>
#include <string>
#include <vector>
#include <optional>

#include "batten/sculpting/session/sculpting_session.h"
#include "batten/apps/commands/shapes/built_model.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/target/fit_model.h"

namespace batten {

// Makes what a scene's lines alone make where it asks for a fair shape, and what a session bends.

/// What fairing a shape did.
struct FairingSummary {
  std::optional<MinimumVariationSurface>
      surface;            ///< set where the change of curvature was made least
  bool requested = true;  ///< false: of regions with five sides or more, without being asked for
  int regions = 0;        ///< how many were faired
  bool lofted = false;    ///< set where the scene asked for a loft
  std::optional<ModelFit> fit;                     ///< set where the scene has a [[target]]
  std::vector<UnchangedRegion> unchanged_regions;  ///< regions that were not faired
  std::string failure_reason;  ///< why it could not be: the shape is then that of least bending
};

/// The shape of a scene's lines, where nothing else acts.
struct FairShape {
  std::shared_ptr<const ModelLayout> layout;  ///< the one it was made on, or a finer one
  Points dofs;                                ///< no rows where failure_reason says why
  /// What was done; rest() of a session that lives on notes here what it did last.
  std::shared_ptr<FairingSummary> fairing;
  /// What a session's surface is bent from; empty where it bends from nothing.
  RestShapeFunction rest;
};

/// Whether a scene asks for another shape of its lines than the one that bends least: by [skin] fair, by
/// a [[target]], or because its curves are a row of sections or bound regions with five sides or more.
bool requests_fair_shape(const Scene& scene, const BuiltModel& made);

/// The shape that fair = "variation" or "loft" asks for, or that is fitted to [[target]]; without being
/// asked for, the one of least variation of regions with five sides or more, where it converges, has no
/// flaw, and stays within 0.15 of the region's size. From `bent`, the dofs that bend least on
/// `layout`. The rest shape of a session is this one, and under other rows of lines, moves and
/// constraints the one that fair_shape() or loft_shape() makes for them. Throws InputError with the
/// place in the scene, CancelledError.
FairShape compute_fair_shape(const Scene& scene, const BuiltModel& made,
                             std::shared_ptr<const ModelLayout> layout, const Points& bent,
                             const Progress& progress = {});

/// The dofs that a scene's lines and material alone make on a layout by bending least.
Points min_bending_shape(const ModelLayout& layout, const Scene& scene,
                         const Progress& progress = {});


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
  std::vector<PointCloudDistances> scans;
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
