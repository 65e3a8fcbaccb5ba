// SPDX-License-Identifier: MPL-2.0
// Adaptive mesh refinement of a shell analysis for a given accuracy of displacements and stresses.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/core/progress.h"
#include "batten/core/solvers/linear_solver_backend.h"

namespace batten {

/// Options of refine_shell().
struct ShellRefinementOptions {
  /// Largest accepted relative error of displacements and of the largest stresses, above 0.
  double accuracy = 0.01;
  int max_meshes = 40;  ///< number of meshes including the first one, 1 or more
  /// Fraction of the total error that the bisected triangles contain (Dörfler marking); above 0, at
  /// most 1.
  double bulk_fraction = 0.7;
  /// Limit of the unknowns of all meshes after the first one together; 0: none.
  long max_total_unknowns = 0;
  BackendFactory backend_factory = {};  ///< linear solver; empty: SparseCholesky
};

/// The last mesh of a refinement, and the results on all meshes.
struct RefinedShell {
  std::shared_ptr<const ModelLayout> layout;  ///< model with the last mesh
  Points shape;  ///< absolute dofs of the middle surface on this layout, n×3
  std::shared_ptr<const ShellModel> shell;  ///< analysis of this shape, with its factorization
  /// One mesh, with the maxima over all load cases.
  struct Mesh {
    double edge_length = 0;   ///< √(twice the mean area of the triangles), model units
    int unknowns = 0;         ///< number of unknowns of the constrained system
    double displacement = 0;  ///< largest displacement, model units
    double von_mises = 0;     ///< largest von Mises stress, force per area
    /// Estimated relative error of the displacements: `error_ratio` times the larger one of the
    /// error of the largest displacement and the error of the work of the loads
    /// (energy_norm_error²).
    double error = 0;
    /// Estimated relative error of the largest stress of each load case, outside of
    /// `singular_places`: the larger of its change since the mesh before and
    /// ShellStresses::Peak::spread.
    double stress_error = 0;
  };
  std::vector<Mesh> meshes;  ///< all meshes in their order; the last one is that of `layout`
  /// True: on the last mesh, `error` and `stress_error` are at most `accuracy`.
  bool converged = false;
  /// Ratio of the error to its estimate by stress recovery on the last mesh, 1 to 5. The estimate is
  /// about the change by halved elements. The ratio is the sum of the geometric series of such
  /// changes, by their observed reduction; √5 on the first mesh, where it is unknown. A first mesh has
  /// converged if five times the estimate is below `accuracy`.
  double error_ratio = 1;
  /// For each load case, places with singular stresses (StressConvergence): point forces and point
  /// supports, and places where the largest stress grows with each refinement (a re-entrant corner,
  /// the end of a support).
  std::vector<std::vector<SingularPlace>> singular_places;
};

/// Refines the mesh of a shell until the displacements and the largest stresses of all load cases
/// have the requested accuracy.
///
/// `layout`, `shape`: the model and the absolute dofs (n×3) of its middle surface on the first
/// mesh. `problem`: the definition and the load cases, computed anew on every mesh. `progress` has
/// the stages "mesh 1", "mesh 2", …, and those of evaluate_load_cases().
///
/// Each round solves the load cases, estimates the errors (evaluate_load_cases()), and bisects the
/// triangles that contribute most to them (Dörfler marking [Dorfler1996]), several times those that
/// contribute much more than others, and those around the largest stress of each case
/// (StressConvergence).
/// The surface is transferred to the new mesh by interpolate_onto(). Triangles smaller than a
/// thousandth of the thickness are not bisected. The refinement stops at `max_meshes`, and before a
/// mesh that does not fit into memory or exceeds `max_total_unknowns`; the last mesh is then
/// returned with `converged` = false.
///
/// Throws InputError for invalid options, and the exceptions of ShellModel and of the functions in
/// `problem`. A MemoryError or NoSolutionError after the first mesh is not thrown: the refinement
/// stops. Cost per
/// mesh: one factorization, and evaluate_load_cases().
RefinedShell refine_shell(std::shared_ptr<const ModelLayout> layout, const Points& shape,
                          const ShellProblem& problem, const ShellRefinementOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
