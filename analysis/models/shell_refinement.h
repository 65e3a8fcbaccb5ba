// Adaptive mesh refinement of a shell analysis for a given accuracy of displacements.
#pragma once

#include <memory>
#include <vector>

#include "batten/analysis/models/shell_results.h"
#include "batten/core/progress.h"
#include "batten/core/solvers/sparse_cholesky.h"

namespace batten {

/// Options of refine_shell().
struct ShellRefinementOptions {
  double accuracy = 0.01;  ///< relative accuracy of displacements, above 0
  int max_meshes = 20;     ///< number of meshes including the first one, 1 or more
  /// Fraction of the error in the triangles that are bisected (Dörfler marking), above 0, up to 1.
  double bulk_fraction = 0.7;
  BackendFactory backend_factory = {};  ///< linear solver; empty: SparseCholesky
};

/// The last mesh of a refinement, and the results on all meshes.
struct RefinedShell {
  std::shared_ptr<const ModelLayout> layout;
  Points shape;  ///< absolute dofs of the middle surface on this layout
  /// One mesh, with the maxima over all load cases.
  struct Mesh {
    double edge_length = 0;  ///< √(twice the mean area of the triangles)
    int unknowns = 0;
    double displacement = 0, von_mises = 0;
    /// Estimated relative error of the displacements: the larger one of the error of the largest
    /// displacement and that of the work of the loads (energy_norm_error²).
    double error = 0;
  };
  std::vector<Mesh> meshes;
  bool converged = false;  ///< true: the error on this mesh is at most the accuracy
};

/// Refines the mesh of a shell until the displacements of all load cases have the requested
/// accuracy.
///
/// Each round solves the load cases, estimates the errors (evaluate_load_cases()), and bisects the
/// triangles that contribute most to them (Dörfler marking [Dorfler1996], ModelLayout::refine()).
/// The surface stays the same: interpolate_onto(). It stops at `max_meshes`, and before a mesh that
/// does not fit into memory; the last mesh is then returned with `converged` = false.
///
/// Throws InputError for invalid options, and the exceptions of ShellModel and of the functions of
/// the problem on the first mesh; ConflictError, NoSolutionError and CancelledError on every mesh.
RefinedShell refine_shell(std::shared_ptr<const ModelLayout> layout, const Points& shape,
                          const ShellProblem& problem, const ShellRefinementOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
