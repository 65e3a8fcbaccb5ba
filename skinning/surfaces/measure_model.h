// Measures a model that has a shape. Internal.
#pragma once

#include "batten/core/progress.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Fills in qualities and areas of the regions, angles of the joins, volumes of the shells, and
/// flaws, of a model that has layout and shape. Joins that its layout gave up become creases.
void measure(SurfaceModel& model, const Progress& progress);

}  // namespace batten
