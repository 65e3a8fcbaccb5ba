// The mesh on which stresses are as exact as asked for.
#pragma once

#include <vector>

#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/core/linear_solver_backend.h"
#include "batten/io/report/stress_report.h"

namespace batten {

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
