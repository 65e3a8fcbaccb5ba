// SPDX-License-Identifier: MPL-2.0
// Translates [stress] of a scene to a shell definition, loads, and a CalculiX deck.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/core/errors.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// Throws InputError if a support or a load of scene.stress is limited by a box: quadrature points
/// enter and leave the box as the shape changes, so that results have no derivatives.
void require_differentiable(const Scene& scene);

/// The shell of a scene: material, thickness, supports, and its load cases followed by their
/// combinations; one case "supports" without load if there are none. Keeps a reference to the
/// scene.
///
/// Its functions throw InputError, with the location in the scene, for unknown curves or faces,
/// points farther from the surface than 0.05 of the model size, and inconsistent units: a modulus
/// in Pa or a density in kg/m³ in a scene in mm, a modulus in MPa or a density in t/mm³ in a scene
/// in m.
ShellProblem shell_problem(const Scene& scene);

// [stress] as a CalculiX deck.

/// The shell of a scene under one load case. Throws DeckLimitError, with the location in the scene,
/// for features that the deck cannot represent; `file` names the deck in messages.
ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file);

}  // namespace batten
