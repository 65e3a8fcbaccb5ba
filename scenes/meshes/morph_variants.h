// SPDX-License-Identifier: MPL-2.0
// Variants of an edited mesh for a design of experiments.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/report/deform_report.h"
#include "batten/scenes/meshes/design_table.h"
#include "batten/scenes/meshes/mesh_dimension.h"
#include "batten/scenes/meshes/morph_solver.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

/// Throws InputError for a parameter that the scene does not have, or a value that is not permitted.
void check_design(const DeformScene& scene, const DesignTable& design);

/// Solves a scene for each row of a design, meets its requirements, and writes each mesh
/// (variant-001/MESH) and variants.csv into the output folder: the values of all parameters of the
/// design and of [[require]], dimensions, largest displacement, element quality, status ("ok", or
/// why the variant failed), and the mesh file.
///
/// Up to thread_count() variants are solved at the same time, each by its own solver; the results do
/// not depend on their number. Adds the result to `report`, and a failed check if a variant failed. Variants without a solution
/// have no mesh. Throws the exceptions of check_design().
void write_variants(DeformReport& report, MorphSolver& solver, const DeformScene& scene,
                    const MeshFile& file, const std::vector<MeshDimension>& dimensions,
                    const DesignTable& design, const OutputFolder& out, const Progress& progress);

}  // namespace batten
