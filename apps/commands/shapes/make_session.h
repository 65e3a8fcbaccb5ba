// Makes the sculpting session of a scene.
#pragma once

#include <string>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

/// Dofs of the surfaces on which things of a scene were placed.
struct SessionReference {
  Points unloaded;     ///< of what the lines alone make
  Points constrained;  ///< under the constraints alone: on it lie the places of loads and weights
};

/// Makes a session with everything that the scene has act on the surface, and with all its
/// parameters at the scene's values. Call solve_to_equilibrium() or start_motion() next.
///
/// The unloaded surface is what the lines alone make. On it lie the nearest places of
/// [[constraint]] in any order, the tangent planes that lines hold, and the normals that moves go
/// along. Places of loads and weights are nearest on the surface under the constraints alone. The
/// same scene and layout give the same session, so that operations recorded on one can be replayed
/// on another.
///
/// `layout`: the model's, or a finer one. `factor_reuse`, `rest`: as in SessionOptions. `start`, unless null,
/// gets the dofs of these surfaces. Throws InputError with the place in the scene for a
/// line or region that the layout does not have, and what SculptingSession throws.
SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                              FactorReuse factor_reuse, const Progress& progress = {},
                              SessionReference* start = nullptr, RestShapeFunction rest = {});

/// Adds a load of the scene, of a point or of pulls, to a session that make_session() made of the
/// other things, with its parameter: the same as if it had been there, but for rounding. `constrained`: as
/// in SessionReference, on the session's layout. Throws as make_session().
void add_load(SculptingSession& session, const Scene& scene, const BuiltModel& made,
              const SceneLoad& load, const Points& constrained);

/// Whether a parameter of the scene is also one of its session. The others (directions of
/// constraints, [[fair]]) have to be set in the scene before.
bool is_session_parameter(const Scene& scene, const std::string& parameter);

}  // namespace batten
