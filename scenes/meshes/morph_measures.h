// SPDX-License-Identifier: MPL-2.0
// Measures the result of a deform scene for its report.
#pragma once

#include <vector>

#include "batten/io/meshes/mesh_file.h"
#include "batten/io/report/deform_report.h"
#include "batten/scenes/meshes/mesh_dimension.h"
#include "batten/scenes/meshes/morph_solver.h"

namespace batten {

/// Adds parameters, statistics of the edits, features, curves, holes, element quality, attached
/// elements and dimensions of the last solution to a report.
void measure_morph(DeformReport& report, const MeshFile& file, const MorphSolver& solver,
                   const std::vector<MeshDimension>& dimensions);

/// Adds a warning for nodes that belong to no shell and do not move while the mesh next to them
/// does.
void warn_left_behind(DeformReport& report, const MeshFile& file, const MorphSolver& solver);

/// The checks that a measured result violates: those of the report, and the [[require]] conditions.
std::vector<FailedCheck> failed_checks(const DeformReport& report, const MorphSolver& solver,
                                       const std::vector<MeshDimension>& dimensions);

}  // namespace batten
