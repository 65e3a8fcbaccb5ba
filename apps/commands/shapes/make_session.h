// Makes the sculpting session of a scene.
#pragma once

#include <string>

#include "batten/apps/commands/shapes/make_model.h"
#include "batten/sculpting/session/session.h"

namespace batten {

/// Makes a session with everything that the scene has act on the surface, and with all its
/// parameters at the scene's values. Call settle() or start_motion() next.
///
/// The unloaded surface is what the lines alone make. On it lie the nearest places of
/// [[constraint]] in any order, the tangent planes that lines hold, and the normals that moves go
/// along. Places of loads and weights are nearest on the surface under the constraints alone. The
/// same scene and layout give the same session, so that operations recorded on one can be replayed
/// on another.
///
/// `layout`: the model's, or a finer one. `expected`, `rest`: as in SessionOptions. `unloaded`, unless
/// null, gets the dofs of the unloaded surface. Throws InputError with the place in the scene for a
/// line or region that the layout does not have, and what SculptingSession throws.
SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                              Expected expected, const Progress& progress = {},
                              Points* unloaded = nullptr, RestShape rest = {});

/// Whether a parameter of the scene is also one of its session. The others (directions of
/// constraints, [[fair]]) have to be set in the scene before.
bool is_live(const Scene& scene, const std::string& parameter);

}  // namespace batten
