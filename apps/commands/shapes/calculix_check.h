// The same shell by CalculiX, as a witness.
#pragma once

#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/io/decks/shell_deck.h"

namespace batten {

/// Writes each load case of a scene as a deck, NAME_CASE_ccx.inp, runs `ccx` on it and puts its
/// largest displacement and equivalent stress, and those where ours are largest, beside ours in
/// report.stress; the .frd file stays beside the deck. CCX names another program. Throws InputError: what a deck cannot hold
/// (deck_of), no such program, a run that leaves no results.
void check_with_calculix(RunContext& run, const Scene& scene, const SolvedShape& shape,
                         ShellDeck::Element element, const Progress& progress);

}  // namespace batten
