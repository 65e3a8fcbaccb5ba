// Rings that run through sections: the surface on which their inner sections are laid. Internal.
#pragma once

#include "batten/skinning/domains/domain_input.h"

namespace batten {

/// A surface on the mesh of a ring through its rims and closed curves between them, in their order:
/// on each line u = const the cubic spline through the sections. Each section lies at one v, by the mean
/// distance from the one before, and runs evenly over u from the phase and in the direction in which
/// it is nearest to the section before. O(vertices · sections).
Surface interpolate_sections(const RegionGeometry& ring, const std::vector<SmoothSegment>& sections,
                             TriangleElement element);

}  // namespace batten
