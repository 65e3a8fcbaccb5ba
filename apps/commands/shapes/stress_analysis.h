// Stress analysis of a scene's shape: report, files and summary; sensitivities to its parameters;
// refinement.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/io/report/report.h"

namespace batten {

/// Analyses the shape as the shell of scene.stress: all load cases and combinations with one
/// factorization and, if requested, buckling factors and natural frequencies. StressFiles writes
/// and draws the results.
///
/// Fills report.stress and report.warnings; adds a failed check if the reactions do not balance the
/// loads. `factors`: linear solver backend; empty: SparseCholesky. Throws InputError with the
/// location in the scene, ConflictError, and NoSolutionError that names an unconstrained motion.
void analyse(RunContext& run, const Scene& scene, const SolvedShape& shape,
             const BackendFactory& factors, const Progress& progress);

/// The lines about the stress analysis in a summary.
std::string stress_summary(const StressReport& report, const std::string& unit);

// Sensitivities of displacements to the parameters of a scene.

/// Computes derivatives with respect to each parameter that changes the shape, for every load case,
/// and stores them in report.stress->sensitivities. The derivatives are those of the largest
/// displacement (at its location, in its direction) and of the compliance (work of the loads).
///
/// Cost: ShellSensitivities; per parameter two shapes. Parameters of [[fair]], driven parameters,
/// and those at a bound in both directions are skipped.
void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress);

// Adaptive mesh refinement for a given accuracy of displacements.

/// A solved shape on smaller elements of the same surface, by refine_shell(). Throws its exceptions.
struct RefinedShape {
  SolvedShape shape;
  std::vector<StressReport::Mesh> meshes;  ///< results on each mesh
  bool converged = false;
};
RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress);

}  // namespace batten
