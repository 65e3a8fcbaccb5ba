// Stress analysis of a solved shape: solution, results, sensitivities and adaptive refinement.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_model.h"
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

/// Like analyse(), but results only: no files, buckling or modes. `where` receives the contribution
/// of each triangle to the error estimates of energy and largest displacement, summed over the
/// cases.
StressReport stresses_of(const Scene& scene, const SolvedShape& shape, VecX& where,
                         const BackendFactory& factors = {}, const Progress& progress = {});

/// Evaluates the maxima over all load cases while a shape changes; reuses everything that stays the
/// same.
class StressEvaluator {
 public:
  explicit StressEvaluator(const Scene& scene) : scene_(scene) {}

  /// Maxima over all load cases.
  struct MaxValues {
    double displacement = 0, von_mises = 0;
  };
  /// Evaluates a shape. Throws the exceptions of stresses_of().
  MaxValues at(const ModelLayout& layout, const Points& dofs);

  /// Results at given locations for the load case with the largest stress, for the shape of the
  /// last at(): the larger von Mises stress of the top and bottom surface, and the displacement (x,
  /// y, z consecutively).
  struct Field {
    std::string load_case;
    std::vector<float> von_mises, displacement;
  };
  Field field(const std::vector<Location>& places) const;

  /// Up to `count` natural modes at given locations, in ascending order of frequency, for the shape
  /// of the last at(). Throws the exceptions of natural_modes().
  struct ModeShapes {
    std::vector<double> frequencies;
    /// x, y, z consecutively; normalised to a maximum of 1.
    std::vector<std::vector<float>> displacements;
  };
  ModeShapes mode_shapes(const std::vector<Location>& places, int count) const;

 private:
  const Scene& scene_;
  ShellDefinition definition_;
  std::optional<ShellModel> shell_;
  std::string governing_case_;  // load case of these displacements
  Points displacement_;
};

/// The lines about the stress analysis in a summary.
std::string stress_summary(const StressReport& report, const std::string& unit);

// Sensitivities of displacements to the parameters of a scene.

/// Computes derivatives with respect to each parameter that changes the shape, for every load case,
/// and stores them in report.stress->sensitivities. The derivatives are those of the largest
/// displacement (at its location, in its direction) and of the compliance (work of the loads).
///
/// Cost: one adjoint solve per case; per parameter two shapes and two stiffness matrices on the
/// same mesh, without factorization. Parameters of [[fair]], driven parameters, and those at a
/// bound in both directions are skipped.
void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress);

// Adaptive mesh refinement for a given accuracy of displacements.

/// A solved shape on smaller elements of the same surface. Triangles with large contributions to
/// the error estimate are bisected (Dörfler marking [Dorfler1996]) until displacements have the
/// relative accuracy `accuracy` in all cases: both the largest displacement and the work of the
/// loads (error_estimate squared). The limit is twenty rounds, and the available memory; beyond
/// that, the last feasible mesh is returned with `converged` = false. Throws the exceptions of
/// run_stress().
struct RefinedShape {
  SolvedShape shape;
  std::vector<StressReport::Mesh> meshes;  ///< results on each mesh
  bool converged = false;
};
RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress);

}  // namespace batten
