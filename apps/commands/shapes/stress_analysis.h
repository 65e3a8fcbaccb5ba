// Stresses of a finished shape: solved, measured, written, drawn.
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

/// Analyses the shape as the shell of scene.stress: each load case and combination from one factor,
/// and where the scene asks for them, buckling factors and natural frequencies. StressFiles writes
/// and draws them. Fills report.stress and report.warnings; report.missed where reactions do not
/// balance the loads. `factors`: of its systems; empty: SparseCholesky. Throws InputError with the place in the scene, ConflictError, NoSolutionError
/// (what is not held, by its motion).
void analyse(RunContext& run, const Scene& scene, const SolvedShape& shape,
             const BackendFactory& factors, const Progress& progress);

/// The numbers of the same analysis: no files, no buckling, no modes. `where` becomes the shares that
/// triangles have in the errors, summed over cases: of the energy, and of the largest displacement.
StressReport stresses_of(const Scene& scene, const SolvedShape& shape, VecX& where,
                         const BackendFactory& factors = {}, const Progress& progress = {});

/// The largest values of all cases while a shape moves: what does not change is kept.
class StressEvaluator {
 public:
  explicit StressEvaluator(const Scene& scene) : scene_(scene) {}

  struct MaxValues {
    double displacement = 0, von_mises = 0;
  };
  /// Throws as stresses_of().
  MaxValues at(const ModelLayout& layout, const Points& dofs);

  /// What the shell does at places of the mesh in the case whose stress is largest, as of the last at():
  /// the larger equivalent stress of both sides, and the displacement (x, y, z one after the other).
  struct Field {
    std::string load_case;
    std::vector<float> von_mises, displacement;
  };
  Field field(const std::vector<Location>& places) const;

  /// How the shell swings at places of the mesh, slowest first, as of the last at(): `count` natural
  /// modes at most. Throws as natural_modes().
  struct ModeShapes {
    std::vector<double> frequencies;
    std::vector<std::vector<float>>
        displacements;  ///< x, y, z one after the other, the largest 1 long
  };
  ModeShapes mode_shapes(const std::vector<Location>& places, int count) const;

 private:
  const Scene& scene_;
  ShellDefinition definition_;
  std::optional<ShellModel> shell_;
  std::string governing_case_;  // the case of these
  Points displacement_;
};

/// The lines of a summary about it.
std::string stress_summary(const StressReport& report, const std::string& unit);


// How stresses answer to the parameters of a scene.

/// For each parameter that changes the shape: the derivatives of the largest displacement (at its
/// place, along its direction) and of the compliance (the work of the loads) of every case, into
/// report.stress->sensitivities. One adjoint solve a case and, for each parameter, two shapes and
/// two stiffnesses on the same mesh, no factor of the shell. Parameters of [[fair]], driven ones and
/// those that can move to neither side are passed over.
void compute_sensitivities(RunContext& run, const Scene& scene, const BuiltModel& made,
                           const SolvedShape& shape, const Progress& progress);


// The mesh on which stresses are as exact as asked for.

/// A finished shape on smaller elements: the same surface, on a mesh that is halved where the error
/// estimate is large (dorfler_marking of what each triangle has in it), until displacements are exact to
/// `accuracy` in all cases: the largest one, and the loads' work (error_estimate squared). Where that
/// takes more than twenty rounds or more memory than there is, the last mesh that could be made:
/// `converged` then says so. Throws as run_stress().
struct RefinedShape {
  SolvedShape shape;
  std::vector<StressReport::Mesh> meshes;  ///< what each of them gave
  bool converged = false;
};
RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress);

}  // namespace batten
