// The words of [stress] as a shell's definition and loads.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_model.h"
#include "batten/apps/commands/shapes/built_model.h"
#include "batten/io/decks/shell_deck.h"

namespace batten {

/// Lines of a layout that are, or are parts of, the line that a scene names. Throws InputError with
/// the place in the scene: none.
std::vector<std::string> find_lines(const ModelLayout& layout, const Scene& scene,
                                    const LocatedString& line);

/// The index, in a layout, of a region that a scene names. Throws InputError as find_lines().
int find_region(const ModelLayout& layout, const Scene& scene, const LocatedString& region);

/// Throws InputError with the place in the scene for numbers that belong to different systems of
/// units: a modulus in Pa or a density in kg/m³ in a scene in mm, a modulus in MPa or a density in
/// t/mm³ in one in m.
void require_consistent_units(const Scene& scene);

/// What the shell of a scene is made of and how it is held. Throws InputError with the place in the
/// scene: lines, regions that are not there; points farther from the surface than half an element.
ShellDefinition shell_definition(const Scene& scene, const ModelLayout& layout,
                                 const Points& shape);

/// The loads of each case, by its name.
std::map<std::string, Points> case_loads(const Scene& scene, const ModelLayout& layout,
                                         const Points& shape, const ShellDefinition& definition);


// [stress] as a deck of CalculiX.

/// The shell of a scene under one load case. Throws InputError with the place in the
/// scene for what such a deck cannot hold; `file` names it.
ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file);

}  // namespace batten
