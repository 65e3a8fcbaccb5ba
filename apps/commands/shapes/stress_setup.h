// Translates [stress] of a scene to a shell definition, loads, and a CalculiX deck.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_model.h"
#include "batten/apps/commands/shapes/built_model.h"
#include "batten/io/decks/shell_deck.h"

namespace batten {

/// Names of the layout's lines that are, or are parts of, a line of the scene. Throws InputError,
/// with the location in the scene, if there are none.
std::vector<std::string> find_lines(const ModelLayout& layout, const Scene& scene,
                                    const LocatedString& line);

/// Layout index of a region of the scene. Throws InputError like find_lines().
int find_region(const ModelLayout& layout, const Scene& scene, const LocatedString& region);

/// Throws InputError, with the location in the scene, for inconsistent units: a modulus in Pa or a
/// density in kg/m³ in a scene in mm, a modulus in MPa or a density in t/mm³ in a scene in m.
void require_consistent_units(const Scene& scene);

/// Material, thickness and supports of a scene's shell. Throws InputError, with the location in the
/// scene, for unknown lines or regions, and for points farther from the surface than half an
/// element.
ShellDefinition shell_definition(const Scene& scene, const ModelLayout& layout,
                                 const Points& shape);

/// The load vector of each load case, by name.
std::map<std::string, Points> case_loads(const Scene& scene, const ModelLayout& layout,
                                         const Points& shape, const ShellDefinition& definition);

// [stress] as a CalculiX deck.

/// The shell of a scene under one load case. Throws InputError, with the location in the scene, for
/// features that the deck cannot represent; `file` names the deck in messages.
ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file);

}  // namespace batten
