// Makes what a scene's lines alone make where it asks for a fair shape, and what a session bends.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/sculpting/session/session_options.h"
#include "batten/skinning/surfaces/fair_model.h"
#include "batten/skinning/target/fit_model.h"

namespace batten {

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

}  // namespace batten
