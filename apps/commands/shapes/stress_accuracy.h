// The mesh on which stresses are as exact as asked for.
#pragma once

#include <vector>

#include "batten/io/report/stress_report.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// The scene with an edge_length at which the estimated error of displacements (of the largest one,
/// and of the loads' work: error_estimate squared) is at most `accuracy` in all cases, and what was
/// found on the way. Makes the shape anew
/// for each of up to six meshes, each a half to four fifths as long as the one before, as the
/// estimate asks for. Where that is not enough, or memory is not, the last one that could be made:
/// its row then says so. Throws as run_stress().
struct AccurateScene {
  Scene scene;
  std::vector<StressReport::Mesh> meshes;
  bool reached = false;
};
AccurateScene accurate_scene(const Scene& scene, double accuracy, const Progress& progress);

}  // namespace batten
