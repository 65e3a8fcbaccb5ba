// Which part of a target each region belongs to. Internal.
#pragma once

#include <memory>
#include <vector>

#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/target/target_surface.h"

namespace batten {

/// For each region the part on which its lines lie, all points of them within `near`; null where there is none.
/// Where there are several, one that no other region has, then the one that is nearest. O(regions · parts),
/// most of them by one nearest point.
std::vector<const TargetSurface*> target_parts_of_regions(
    const ModelLayout& layout, const std::vector<std::shared_ptr<const TargetSurface>>& parts,
    double near);

/// For each region with a part of its own the part's points over the region's domain, their rims on each other; none
/// for rings, and where a rim of the part is farther than `near` from the region's. `dofs`: a shape that has the lines.
std::vector<TargetSurface::Parametrization> parametrizations_of_regions(
    const ModelLayout& layout, const Points& dofs, const std::vector<const TargetSurface*>& parts,
    double near);

}  // namespace batten
