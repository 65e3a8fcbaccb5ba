// Weighs the dofs by how much a change of each one moves the surface. Internal.
#pragma once

#include "batten/fem/trim.h"

namespace batten {

/// Returns one number for each dof; |Δq| times it is a length in model units. It is 1 for
/// positions, and for slopes √(2 area) of the largest triangle of the domain that has the dof. It
/// is 0 for dofs that belong only to triangles of which less than a twentieth lies inside of the
/// trim: rounding moves these, and they change nothing that is seen.
VecX displacement_weights(const ParametricMesh& mesh, const Trim* trim);

}  // namespace batten
