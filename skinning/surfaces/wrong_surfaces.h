// Surfaces that turn over, fold, cross each other or are far too large.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The flaws of finished regions (wrong_surfaces.cpp), kind after kind as they are found; indices
/// are those of `regions`, null ones are passed over. `plain_areas`: one for each, 0 unknown. Seen
/// on facets, four for each element:
///
///   Jacobian  min_jacobian_ratio of the quality is not above 0;
///   Fold      inside of a region, normals of neighbouring facets differ by more than 90 degrees:
///             nothing that lines ask for is so sharp. Where two regions meet along a line a crease
///             of any angle may be wanted, the 90 degrees of a box as well as a thin rim; what is
///             not is that one lies back on the other. So the wedge between them is measured, 180
///             degrees where they go on in one plane: below 30 along more than a tenth of their
///             common way it is a flaw, whose value is 180 less the sharpest wedge. A knife's edge
///             is named too;
///   Crossing  facets without a common point that pass through each other or overlap in one plane
///             (facet_crossings.h). Near lines that regions share within a gap only, a tenth of an
///             edge is let pass;
///   Area      more than twice `plain_areas`.
///
/// One flaw for each kind and region or pair of regions. O(facets log facets). Throws InputError:
/// counts that differ, and what facets() throws.
std::vector<SurfaceFlaw> find_flaws(const std::vector<const SkinnedRegion*>& regions,
                                    const std::vector<SkinQuality>& qualities,
                                    const std::vector<double>& plain_areas);

}  // namespace batten
