// SPDX-License-Identifier: MPL-2.0
// Results at the points, curves and faces that [stress] requests.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/analysis/models/shell_stresses.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// Values of one load case at all SceneStress::results. Throws InputError, with the location in the
/// scene, for an unknown curve or face, and a point that is far from the surface.
std::vector<StressReport::Case::Result> requested_results(const Scene& scene,
                                                          const ShellModel& shell,
                                                          const ShellCaseResult& result,
                                                          const ShellStresses& stresses);

/// Writes the values along the curve of a result as CSV, one row per point: distance along the curve,
/// position, displacement, von Mises stress at the top, in the middle and at the bottom, and membrane
/// forces and moments along the curve, across it, and in shear (twist). A header names the columns with
/// their units.
void write_curve_values(std::ostream& out, const Scene& scene, const ShellModel& shell,
                        const ShellCaseResult& result, const ShellStresses& stresses,
                        const SceneStress::Result& of);

}  // namespace batten
