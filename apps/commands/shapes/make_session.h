// Makes the sculpting session of a scene.
#pragma once

#include <string>

#include "batten/apps/commands/shapes/make_model.h"
#include "batten/sculpting/session/session.h"

namespace batten {

/// Dofs of the surfaces on which things of a scene were placed.
struct SessionStart {
  Points unloaded;  ///< of what the lines alone make
  Points held;      ///< under the constraints alone: on it lie the places of loads and weights
};

/// Makes a session with everything that the scene has act on the surface, and with all its
/// parameters at the scene's values. Call settle() or start_motion() next.
///
/// The unloaded surface is what the lines alone make. On it lie the nearest places of
/// [[constraint]] in any order, the tangent planes that lines hold, and the normals that moves go
/// along. Places of loads and weights are nearest on the surface under the constraints alone. The
/// same scene and layout give the same session, so that operations recorded on one can be replayed
/// on another.
///
/// `layout`: the model's, or a finer one. `expected`, `rest`: as in SessionOptions. `start`, unless null,
/// gets the dofs of these surfaces. Throws InputError with the place in the scene for a
/// line or region that the layout does not have, and what SculptingSession throws.
SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const MadeModel& made,
                              Expected expected, const Progress& progress = {},
                              SessionStart* start = nullptr, RestShape rest = {});

/// Adds a load of the scene, of a point or of pulls, to a session that make_session() made of the
/// other things, with its parameter: the same as if it had been there, but for rounding. `held`: as
/// in SessionStart, on the session's layout. Throws as make_session().
void add_load(SculptingSession& session, const Scene& scene, const MadeModel& made,
              const SceneLoad& load, const Points& held);

/// Whether a parameter of the scene is also one of its session. The others (directions of
/// constraints, [[fair]]) have to be set in the scene before.
bool is_live(const Scene& scene, const std::string& parameter);

}  // namespace batten
