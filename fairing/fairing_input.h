// What the fairing of a surface expects of its start. Internal.
#pragma once

#include "batten/constraints/constraint_set.h"
#include "batten/fem/surface.h"

namespace batten {

/// Throws InputError: constraints for another number of dofs, a dof that is not finite, a start
/// without area.
void check_fairing_input(const Surface& start, const ConstraintSet& constraints);

}  // namespace batten
