// Pictures of a deformed mesh.
#pragma once

#include <vector>

#include "batten/apps/commands/meshes/deform_task.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/io/report/deform_report.h"

namespace batten {

/// Draws the pictures of a scene. `states`: places of all vertices before the first edit and after each.
void draw_deformed(DeformReport& report, const DeformScene& scene, const MeshFile& file,
                   const std::vector<Points>& states, const std::vector<Task>& tasks,
                   const Kept& kept, const OutputFolder& out);

}  // namespace batten
