// Translates [stress] of a scene to a shell definition, loads, and a CalculiX deck.
#pragma once

#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/apps/commands/shapes/built_model.h"
#include "batten/io/decks/shell_deck.h"

namespace batten {

/// Names of the layout's lines that are, or are parts of, a line of the scene. Throws InputError,
/// with the location in the scene, if there are none.
std::vector<std::string> find_lines(const ModelLayout& layout, const Scene& scene,
                                    const LocatedString& line);

/// Layout index of a region of the scene. Throws InputError like find_lines().
int find_region(const ModelLayout& layout, const Scene& scene, const LocatedString& region);

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

/// The shell of a scene under one load case. Throws InputError, with the location in the scene, for
/// features that the deck cannot represent; `file` names the deck in messages.
ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file);

}  // namespace batten
