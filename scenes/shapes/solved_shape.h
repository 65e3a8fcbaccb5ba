// SPDX-License-Identifier: MPL-2.0
// The model of a scene, and its shape under all loads and constraints of the scene.
#pragma once

#include <memory>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/shapes/fair_shape.h"
#include "batten/skinning/surfaces/build_model.h"

namespace batten {

// Model of a scene: how the tables of the scene determine the options of build_model().

/// The options that a scene states for its model. `lines`: the scene's curves, of a half model with
/// their mirror images. They refer to the scene, which must outlive them.
ModelBuildOptions model_build_options(const Scene& scene, const std::vector<CharacterLine>& lines);

/// True if a scene specifies how its single region is made: domain, mesher, three stiffnesses,
/// `hold`, treatments, or a loft.
bool specifies_single_region(const Scene& scene);

/// Builds the model of the scene's curves, which does not depend on loads and constraints. The
/// model is a single region if the scene specifies it or the line roles leave one outline; the loft
/// of a series of sections; or else the network of all faces that the curves bound. Throws the
/// exceptions of build_model() in skinning/surfaces/build_model.h, with the location in the scene.
BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress = {});

// Fair shape of a scene's lines, which is also the rest shape of its session.

/// True if the scene's lines get another shape than the one of minimum bending: because of [skin]
/// fair or a [[target]], or because its curves are a series of sections or bound regions with five
/// or more sides.
bool requests_fair_shape(const Scene& scene, const BuiltModel& made);

/// The smallest tolerance of the targets of a scene, [[target]]; a target without one has 1e-4 of
/// the model's size.
double target_tolerance(const Scene& scene, double size);

/// Reads the scene's targets, if any, and computes the shape that the scene requests, or that its
/// faces get automatically (skinning/shapes/fair_shape.h).
///
/// `bent`: dofs of the minimum-bending shape on `layout`, used as the start. Throws the exceptions
/// of target_parts() and compute_fair_shape(), with the location in the scene.
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
