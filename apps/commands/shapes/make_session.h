// From a scene to a sculpting session.
#pragma once

#include <string>

#include "batten/apps/commands/shapes/make_model.h"
#include "batten/sculpting/session/session.h"

namespace batten {

/// A session with everything of the scene on it, and all its parameters at the scene's values;
/// settle() or start_motion() comes next. Places of [[constraint]] are nearest on the unloaded
/// surface, whatever their order; tangent planes that lines hold, and the normals that moves go
/// along, are those of the unloaded surface, too. Places of loads and weights are nearest on the
/// surface under the constraints alone. The same scene and layout give the same session, so that
/// what was recorded on one can be replayed on another. `layout`: the model's, or a finer one;
/// `expected` as in SessionOptions; `unloaded`: gets the dofs of what the lines alone make. Throws
/// InputError with the place in the scene: a line or region that the layout does not have; what
/// SculptingSession throws.
SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                              Expected expected, const Progress& progress = {},
                              Points* unloaded = nullptr);

/// Whether a parameter of the scene is one of its session; the others (directions of constraints,
/// [[fair]]) are set in the scene before.
bool is_live(const Scene& scene, const std::string& parameter);

}  // namespace batten
