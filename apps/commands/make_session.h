// From a scene to a sculpting session.
#pragma once

#include <optional>
#include <string>

#include "batten/apps/commands/make_shape.h"
#include "batten/io/scene.h"
#include "batten/sculpting/session.h"

namespace batten {

/// A session with everything of the scene on it, and all its parameters at the scene's values;
/// settle() or start_motion() comes next. Places of [[constraint]] are nearest on the unloaded
/// surface, whatever their order; tangent planes that lines hold, and the normals that moves go
/// along, are those of the unloaded surface, too. Places of loads and weights are nearest on the
/// surface under the constraints alone. The same scene and layout give the same session, so that
/// what was recorded on one can be replayed on another. `unloaded`: what the lines alone make.
/// Throws InputError with the place in the scene: a line that the layout does not have; what
/// SculptingSession throws.
SculptingSession make_session(RegionLayout layout, const Scene& scene,
                              const Progress& progress = {},
                              std::optional<Surface>* unloaded = nullptr);

/// Halves the layout's triangles where the settled shape of the scene's own values leaves embedded
/// lines by more than the tolerance, as make_refined_shape(). A scene whose own values have no
/// solution leaves the layout as it is.
void refine_for_lines(RegionLayout& layout, const Scene& scene, const Progress& progress = {});

/// Whether a parameter of the scene is one of its session; the others (directions of constraints,
/// [[fair]]) are set in the scene before.
bool is_live(const Scene& scene, const std::string& parameter);

/// The session's shape as it is, as other commands know shapes. `answer`: of the last settle().
MadeShape shape_of(const SculptingSession& session, const Scene& scene, const Surface& unloaded,
                   const Answer& answer);

}  // namespace batten
