// The mesh on which stresses are as exact as asked for.
#pragma once

#include <vector>

#include "batten/apps/commands/shapes/make_shape.h"
#include "batten/core/other_factor.h"
#include "batten/io/report/stress_report.h"

namespace batten {

/// A finished shape on smaller elements: the same surface, on a mesh that is halved where the error
/// estimate is large (largest_share of what each triangle has in it), until displacements are exact to
/// `accuracy` in all cases: the largest one, and the loads' work (error_estimate squared). Where that
/// takes more than twenty rounds or more memory than there is, the last mesh that could be made:
/// `reached` then says so. Throws as run_stress().
struct AccurateShape {
  MadeShape shape;
  std::vector<StressReport::Mesh> meshes;  ///< what each of them gave
  bool reached = false;
};
AccurateShape accurate_shape(const Scene& scene, const MadeShape& shape, double accuracy,
                             const FactorMaker& factors, const Progress& progress);

}  // namespace batten
