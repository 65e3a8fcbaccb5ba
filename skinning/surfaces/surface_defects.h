// Finds surfaces that turn over, fold, cross each other or are far too large.
#pragma once

#include <vector>
#include <array>
#include <utility>

#include "batten/skinning/surfaces/surface_model.h"
#include "batten/core/eigen.h"

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


// Finds facets of many surfaces that pass through each other.

/// Two facets, a < b, and a point that lies on both.
struct FacetIntersection {
  int a, b;
  Vec3 where;
};

/// Returns the pairs of facets that pass through each other: an edge of one pierces the other, or
/// both lie in one plane and overlap. `facets`: the points of each facet; `joined`: the same, but
/// with one index for points that count as one wherever they lie. Pairs that have such an index in
/// common do not count. Nor do pairs that cross only within `near` of free sides of both, where two surfaces meet along a line that each follows with points of its own.
/// Facets of area zero cross nothing, nor do those with a corner that is not finite. Pairs are ordered by a, then b. O(n) for facets of similar
/// size, by a grid of cells; on all threads.
std::vector<FacetIntersection> facet_intersections(const std::vector<Vec3>& points,
                                                   const std::vector<std::array<int, 3>>& facets,
                                                   const std::vector<std::array<int, 3>>& joined,
                                                   const std::vector<int>& surface_of, double near);

/// Returns the sides that no other facet of their surface has, as (facet, side), ascending: side i
/// runs from corner i to corner i + 1. Empty `surface_of`: all are of one surface. O(n log n).
std::vector<std::pair<int, int>> boundary_sides(const std::vector<std::array<int, 3>>& facets,
                                                const std::vector<int>& surface_of = {});

}  // namespace batten
