// SPDX-License-Identifier: MPL-2.0
// Solves the requirements of a deform scene for its parameters.
#pragma once

#include <vector>

#include "batten/core/progress.h"
#include "batten/io/report/run_report.h"
#include "batten/scenes/meshes/mesh_dimension.h"
#include "batten/scenes/meshes/morph_solver.h"

namespace batten {

/// Changes the parameters of `scene` that [[require]] names until all requirements hold, and solves
/// the edits. Inequalities that hold without a change leave their parameter alone; the others become
/// equations (active-set method).
///
/// Newton's method with a Jacobian by central differences, and step halving; a requirement holds if
/// its dimension deviates by at most 1e-9, relative to the largest of the required value, the value
/// and the size of the mesh (to the power of the dimension). Throws NoSolutionError, with the
/// location and the nearest value, if it does not converge in 30 iterations, or a parameter does not
/// change its dimension, and the exceptions of MorphSolver::solve().
void meet_requirements(MorphSolver& solver, DeformScene& scene,
                       const std::vector<MeshDimension>& dimensions, const Progress& progress = {});

/// The requirements that do not hold at vertex positions (n×3).
std::vector<FailedCheck> unmet_requirements(const DeformScene& scene,
                                            const std::vector<MeshDimension>& dimensions,
                                            const TriangleMesh& mesh, const Points& points);

/// The condition of a requirement: "= 20", "<= 20", ">= 20".
std::string condition_text(const RequirementSpec& rule);

}  // namespace batten
