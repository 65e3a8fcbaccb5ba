// SPDX-License-Identifier: MPL-2.0
// How much the loads, curve offsets and sliders of a scene displace its surface.
#pragma once

#include <string>
#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/report.h"
#include "batten/scenes/gradients.h"
#include "batten/scenes/shapes/solved_shape.h"

namespace batten {

/// Computes the effect of each load, curve offset and slider ([[parameter]]) on a solved shape, with
/// one or two solves for each: the change of the shape for a small change of the parameter from the
/// value of the scene. Parameters that may not be changed, driven ones, and those for which there is
/// no solution are left out. Throws the exceptions of make_session().
std::vector<LoadEffect> load_effects(const Scene& scene, const BuiltModel& made,
                                     const SolvedShape& shape, const Progress& progress = {});

/// One line for each effect: "swell: 1 displaces the surface by up to 0.4 mm, at (…) on face 'door';
/// 25 displaces it by about 1 % of its size". Empty without effects.
std::string effects_text(const std::vector<LoadEffect>& effects, const std::string& unit);

/// Adds a warning if the loads of a scene displace the surface by less than 1e-6 or by more than 10
/// times its size, with the values that would displace it by 1 %.
void check_load_sizes(Report& report, const Scene& scene);

}  // namespace batten
