// SPDX-License-Identifier: MPL-2.0
// Creates the sculpting session of a scene.
#pragma once

#include <string>

#include "batten/io/scene/scene.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/surfaces/build_model.h"

namespace batten {

/// Dofs of the reference surfaces on which a scene's constraints and loads are located.
struct SessionReference {
  Points unloaded;     ///< shape of the lines alone
  Points constrained;  ///< shape with constraints only; loads and weights are located on it
};

/// Creates a session with all loads, constraints, weights and moves of the scene, and all
/// parameters at the scene's values. Its undo history begins here. Call solve_to_equilibrium() or
/// start_motion() next.
///
/// The unloaded surface is the shape of the lines alone. Constraints, tangent planes that lines
/// preserve, and the normals that moves follow are located at its nearest points, independently of
/// their order. Loads and weights are located at the nearest points of the surface under the
/// constraints alone. The same scene and layout give the same session, so operations recorded on
/// one can be replayed on the other.
///
/// `layout`: that of the model, or a refinement. `factor_reuse`, `rest`: see SessionOptions.
/// `start`: if not null, receives the dofs of the reference surfaces. Throws InputError, with the
/// location in the scene, for a line or region that the layout does not have, and the exceptions of
/// SculptingSession.
SculptingSession make_session(const ModelLayout& layout, const Scene& scene, const BuiltModel& made,
                              FactorReuse factor_reuse, const Progress& progress = {},
                              SessionReference* start = nullptr, RestShapeFunction rest = {});

/// Adds a point load or attractor springs of the scene, with its parameter, to a session that
/// make_session() created without it. The result equals a session created with it, up to rounding.
/// `constrained`: see SessionReference, on the session's layout. Throws the exceptions of
/// make_session().
void add_load(SculptingSession& session, const Scene& scene, const BuiltModel& made,
              const SceneLoad& load, const Points& constrained);

/// True if a parameter of the scene is also a parameter of its session. All others (directions of
/// constraints, [[fair]]) must be set in the scene before the session is created.
bool is_session_parameter(const Scene& scene, const std::string& parameter);

}  // namespace batten
