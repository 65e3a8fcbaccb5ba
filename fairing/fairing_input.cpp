#include "batten/fairing/fairing_input.h"

#include "batten/core/errors.h"

namespace batten {

void check_fairing_input(const Surface& start, const ConstraintSet& constraints) {
  const int n = start.dof_map().count();
  if (constraints.dof_count() != n)
    throw InputError("constraints on " + std::to_string(constraints.dof_count()) +
                     " dofs for a surface with " + std::to_string(n));
  if (!start.dofs().allFinite()) throw InputError("a dof of the surface is not finite");
  if (!(start.area() > 0)) throw InputError("a surface of area zero cannot be faired");
}

}  // namespace batten
