// The surfaces of [[target]].
#pragma once

#include "batten/apps/commands/shapes/target_faces.h"
#include "batten/core/progress.h"
#include "batten/io/scene/scene.h"

namespace batten {

/// The smallest of the tolerances that a scene states, 1e-4 of the model's size for those that state none.
double target_tolerance(const Scene& scene, double size);

/// All targets of a scene as one surface, in the scene's unit: meshes as they are, faces of CAD files as
/// curved triangles within a quarter of the tolerance. Throws InputError that begins with the place in the scene.
TargetParts target_of(const Scene& scene, double size, const Progress& progress = {});

}  // namespace batten
