// Rings that run through sections: the surface on which their inner sections are laid. Internal.
#pragma once

#include "batten/skinning/domains/domain_task.h"

namespace batten {

/// A surface on the mesh of a ring through its rims and closed curves between them, in their order:
/// on each line u = const the cubic spline through the sections. Each section lies at one v, by the mean
/// distance from the one before, and runs evenly over u from the phase and in the direction in which
/// it is nearest to the section before. O(vertices · sections).
Surface through_sections(const RegionParts& ring, const std::vector<Stretch>& sections,
                         TriangleElement element);

}  // namespace batten
