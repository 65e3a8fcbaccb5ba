// Pictures of a deformed mesh.
#pragma once

#include <vector>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/io/report/deform_report.h"

namespace batten {

/// Draws the pictures of a scene. `states`: places of all vertices before the first edit and after each.
void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<DeformTask>& tasks,
                   const SharedConstraints& shared, const OutputFolder& out);

}  // namespace batten
