// How much a change of each dof is a change of the surface. Internal.
#pragma once

#include "batten/fem/trim.h"

namespace batten {

/// One number a dof, so that |Δq| times it is a length over the region's size: 1 for positions, the
/// size of the triangle for slopes, 0 for dofs whose triangles lie outside of the trim but for a
/// twentieth: those are loose, and move by rounding that nobody sees.
VecX change_weights(const ParametricMesh& mesh, const Trim* trim);

}  // namespace batten
