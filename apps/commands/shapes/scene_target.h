// The surfaces of [[target]].
#pragma once

#include <memory>

#include "batten/core/progress.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// The smallest of the tolerances that a scene states, 1e-4 of the model's size for those that state none.
double target_tolerance(const Scene& scene, double size);

/// All targets of a scene as one surface, in the scene's unit: meshes as they are, faces of CAD files as
/// curved triangles within a quarter of the tolerance. Samples are not farther apart than 1/100 of the size. Throws InputError that begins with the place in the scene.
std::shared_ptr<const TargetSurface> target_of(const Scene& scene, double size,
                                               const Progress& progress = {});

}  // namespace batten
