// Solves the shape of a model under all loads and constraints of a scene.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/target/fit_model.h"

namespace batten {

// Fair shape of a scene's lines, which is also the rest shape of its session.

/// What fairing did to a shape.
struct FairingSummary {
  /// Set if the shape is a minimum-variation surface.
  std::optional<MinimumVariationSurface> surface;
  bool requested = true;        ///< false: chosen automatically for regions with five or more sides
  int regions = 0;              ///< number of faired regions
  bool lofted = false;          ///< true: the scene requested a loft
  std::optional<ModelFit> fit;  ///< set if the scene has a [[target]]
  std::vector<UnchangedRegion> unchanged_regions;  ///< regions that were not faired
  std::string failure_reason;  ///< if not empty: why fairing failed; the shape is then the one of
                               ///< minimum bending
};

/// The shape of a scene's lines, without loads and constraints.
struct FairShape {
  std::shared_ptr<const ModelLayout> layout;  ///< the input layout, or a refinement
  Points dofs;                                ///< no rows if failure_reason is set
  /// Result of fairing. The function rest() of a live session updates it.
  std::shared_ptr<FairingSummary> fairing;
  /// Rest shape of the session's surface; empty: flat rest state.
  RestShapeFunction rest;
};

/// True if the scene's lines get another shape than the one of minimum bending: because of [skin]
/// fair or a [[target]], or because its curves are a series of sections or bound regions with five
/// or more sides.
bool requests_fair_shape(const Scene& scene, const BuiltModel& made);

/// Computes the shape for fair = "variation" or "loft", or fits it to [[target]]. If none is
/// requested, it computes the minimum-variation shape of regions with five or more sides, and keeps
/// it if the solution converges, has no defect, and stays within 0.15 of the region's size.
///
/// `bent`: dofs of the minimum-bending shape on `layout`, used as the start. The result is the rest
/// shape of a session; under other line constraints, moves and constraints, fair_shape() or
/// loft_shape() recomputes it. Throws InputError with the location in the scene, and
/// CancelledError.
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
