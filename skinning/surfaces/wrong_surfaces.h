// Finds surfaces that turn over, fold, cross each other or are far too large.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Returns the flaws of finished regions, kind after kind. Their indices are those of `regions`, of
/// which null ones are passed over. `plain_areas`: one for each region, 0: unknown. Flaws are
/// looked for on facets, four for each element:
///
///   Jacobian  min_jacobian_ratio of the quality is not above 0;
///   Fold      inside of a region, normals of neighbouring facets differ by more than 120 degrees:
///             no lines ask for that. Where two regions meet along a line a crease of any angle may
///             be wanted, that of a box as well as that of a thin rim, but not that one region lies
///             back on the other. So the wedge between them is measured, which is 180 degrees where
///             they go on in one plane: a wedge below 30 degrees along more than a tenth of their
///             common line is a flaw, with the value 180 less the sharpest wedge. A knife's edge is
///             such a flaw too;
///   Crossing  facets without a common point that pass through each other or overlap in one plane
///             (facet_crossings.h). Near lines that regions share only within a gap, crossings
///             within a tenth of an edge do not count;
///   Area      more than twice `plain_areas`.
///
/// One flaw for each kind and region or pair of regions. O(facets log facets). Throws InputError:
/// counts that differ, and what facets() throws.
std::vector<SurfaceFlaw> find_flaws(const std::vector<const SkinnedRegion*>& regions,
                                    const std::vector<SkinQuality>& qualities,
                                    const std::vector<double>& plain_areas);

}  // namespace batten
