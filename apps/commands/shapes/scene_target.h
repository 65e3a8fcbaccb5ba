// Target surfaces of [[target]].
#pragma once

#include "batten/core/progress.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/mesh_targets/mesh_target.h"

namespace batten {

/// The smallest tolerance of the scene's targets; a target without one has 1e-4 of the model's
/// size.
double target_tolerance(const Scene& scene, double size);

/// Combines all targets of a scene into one surface in the scene's unit. Meshes are used unchanged;
/// CAD faces become curved triangles within a quarter of the tolerance. Throws InputError that
/// begins with the location in the scene.
TargetParts target_of(const Scene& scene, double size, const Progress& progress = {});

}  // namespace batten
