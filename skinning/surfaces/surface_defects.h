// Finds surfaces that turn over, fold, cross each other or are far too large.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Returns the flaws of finished regions, kind after kind. Their indices are those of `regions`, of
/// which null ones are passed over. `filling_areas`: one for each region, 0: unknown. Flaws are
/// looked for on facets, four for each element:
///
///   Jacobian  min_jacobian_ratio of the quality is not above 0;
///   Fold      inside of a region, normals of neighbouring facets differ by more than 120 degrees:
///             no lines ask for that. Where two regions meet along a line a crease of any angle may
///             be wanted, that of a box as well as a knife's edge, but not that one region lies back
///             on the other. So the wedge between them is measured, which is 180 degrees where they
///             go on in one plane, and compared with the one that the curves ask for: at the ends of
///             the line both regions have another curve, which fixes their tangent planes there;
///             between, it is linear. A flaw is a wedge below 30 degrees and below half of what is
///             asked for (or below 0.05 degrees), along more than a tenth of the common line. Where
///             no curve fixes a plane (closed lines without nodes) 30 degrees count. The value is
///             180 less the sharpest such wedge;
///   Crossing  facets without a common point that pass through each other or overlap in one plane
///             (facet_intersections.h). Near lines that regions share only within a gap, crossings
///             within a tenth of an edge do not count, nor beside edges below 30 degrees those that
///             are no deeper than facets lie off their surfaces;
///   Area      more than twice `filling_areas`.
///
/// One flaw for each kind and region or pair of regions. O(facets log facets). Throws InputError:
/// counts that differ, and what facets() throws.
std::vector<SurfaceDefect> find_defects(const std::vector<const SkinnedRegion*>& regions,
                                        const std::vector<SkinQuality>& qualities,
                                        const std::vector<double>& filling_areas);

}  // namespace batten
