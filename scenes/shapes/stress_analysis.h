// SPDX-License-Identifier: MPL-2.0
// Stress analysis of a scene's shape: files, pictures and summary; comparison with CalculiX.
// The results themselves are computed in stress_results.h.
#pragma once

#include <string>
#include <vector>

#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/report/report.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/scenes/shapes/stress_results.h"

namespace batten {

/// Analyses the shape as the shell of scene.stress (compute_stresses()), and writes and draws the
/// results:
///
///     NAME_CASE.vtu        a load case on the undeformed shape: Displacement, Von_mises_top,
///                          _middle and _bottom, Stress_top, _middle and _bottom, Forces, Moments
///                          and Thickness (tensors as xx, yy, zz, xy, yz, xz)
///     NAME_CASE.png        its equivalent stress on the deformed shape
///     NAME_KIND_1.vtu, …   mode shapes (KIND: "modes", "CASE buckling"): Displacement, normalised
///                          to a maximum of 1; NAME_KIND.pvd is their series
///     NAME_KIND.png        a contact sheet of the mode shapes with captions
///     NAME_KIND_1.gif, …   animations of the mode shapes, if `animations` is true
///
/// Fills report.stress and report.warnings; adds a failed check if the reactions do not balance the
/// loads. Throws the exceptions of compute_stresses().
void analyse(RunContext& run, const Scene& scene, const RefinedShape& refined,
             const StressAccuracy& accuracy, const BackendFactory& factors, bool animations,
             const Progress& progress);

/// Magnification of drawn displacements for a model of this size: a factor 1, 2 or 5 times a power
/// of ten, so that the largest displacement is at most a twentieth of the size.
double deformation_scale(double largest, double size);

/// The lines about the stress analysis in a summary.
std::string stress_summary(const StressReport& report, const std::string& unit);

// Comparison with CalculiX.

/// Writes each load case of a scene as a deck, NAME_CASE_ccx.inp, runs `ccx` on it, and adds its
/// results to report.stress: the maxima of displacement and equivalent stress, and the values where
/// our maxima are. The .frd file stays beside the deck. The environment variable CCX selects
/// another executable. Throws InputError for features that a deck cannot represent (deck_of), a
/// missing executable, or a run without results.
void check_with_calculix(RunContext& run, const Scene& scene, const SolvedShape& shape,
                         ShellDeck::Element element, const Progress& progress);

}  // namespace batten
