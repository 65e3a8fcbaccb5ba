// Inner lines end where a hole takes the surface away.
#pragma once

#include <vector>

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// Cuts inner lines at the rims of holes and drops what lies in a hole; a line of which several
/// pieces are left becomes "name.1", "name.2", … Rim and line must meet within the task's join
/// distance where they cross, seen along the mean normal of the hole. Given curves stay whole: a
/// network has cut them. Cost: O(samples of lines × samples of rims).
/// Throws InputError: a line that passes a rim farther away (with both names, place, distance and
/// remedy), a line that lies in a hole from end to end.
std::vector<SmoothSegment> split_at_holes(const std::vector<SmoothSegment>& inner,
                                          const std::vector<Outline>& holes,
                                          const DomainInput& task);

}  // namespace batten
