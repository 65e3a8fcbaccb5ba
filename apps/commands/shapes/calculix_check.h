// Cross-check of the shell solution against CalculiX.
#pragma once

#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/io/decks/shell_deck.h"

namespace batten {

/// Writes each load case of a scene as a deck, NAME_CASE_ccx.inp, runs `ccx` on it, and adds its
/// results to report.stress: the maxima of displacement and equivalent stress, and the values where
/// our maxima are. The .frd file stays beside the deck. The environment variable CCX selects
/// another executable. Throws InputError for features that a deck cannot represent (deck_of), a
/// missing executable, or a run without results.
void check_with_calculix(RunContext& run, const Scene& scene, const SolvedShape& shape,
                         ShellDeck::Element element, const Progress& progress);

}  // namespace batten
