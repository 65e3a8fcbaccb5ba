// [stress] as a deck of CalculiX.
#pragma once

#include <string>

#include "batten/apps/commands/shapes/built_model.h"
#include "batten/io/decks/calculix.h"

namespace batten {

/// The shell of a scene under one load case. Throws InputError with the place in the
/// scene for what such a deck cannot hold; `file` names it.
ShellDeck deck_of(const Scene& scene, const ModelLayout& layout, const std::string& load_case,
                  const std::string& file);

}  // namespace batten
