// Finds defects of surfaces: inverted, folded, intersecting or far too large regions.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// Finds the defects of finished regions, ordered by kind.
///
/// Region indices refer to `regions`; null entries are skipped. `filling_areas`: one per region,
/// area of the hole-filling triangulation; 0: unknown. The surfaces are checked on facets, four per
/// element:
///
///  Jacobian  min_jacobian_ratio of the quality is not positive;
///  Fold      inside a region: normals of adjacent facets differ by more than 120°, which no lines
///            require. Between two regions along a line: a crease of any angle can be intended,
///            from a box to a knife edge, but one region must not lie back on the other. The wedge
///            angle between them (180° if they continue in one plane) is therefore compared with
///            the angle that the curves require. At the ends of the line each region has another
///            curve, which fixes its tangent plane there; in between, the required angle is linear.
///            The defect is a wedge below 30° and below half of the required angle (or below
///            0.05°), over more than a tenth of the common line. If no curve fixes a plane (closed
///            lines without nodes), the limit is 30°. The value is 180° minus the sharpest wedge;
///  Crossing  facets without a common point that intersect, or overlap in one plane
///            (facet_intersections()). Near lines that the regions share only within a gap,
///            intersections within a tenth of an edge length are ignored. Near edges with a wedge
///            below 30°, those no deeper than the distance of the facets from their surfaces are
///            ignored;
///  Area      more than twice `filling_areas`.
///
/// At most one defect is reported per kind and region, or pair of regions. Cost: O(facets log
/// facets). Throws InputError if the array lengths differ, and as facets() does.
std::vector<SurfaceDefect> find_defects(const std::vector<const SkinnedRegion*>& regions,
                                        const std::vector<SkinQuality>& qualities,
                                        const std::vector<double>& filling_areas);

// Intersections of facets.

/// Two intersecting facets, a < b, and a common point.
struct FacetIntersection {
  int a, b;
  Vec3 where;
};

/// Finds the pairs of facets that intersect: an edge of one pierces the other, or they overlap in
/// one plane.
///
/// `facets`: point indices of each facet. `joined`: the same, but with one index for points that
/// are identified regardless of their position. Pairs with a common index in `joined` are ignored.
/// So are pairs that intersect only within `near` (model units) of boundary sides of both: there,
/// two surfaces meet along a line that each follows with its own points. `surface_of`: surface of
/// each facet. Facets of zero area and facets with non-finite corners intersect nothing. Pairs are
/// ordered by a, then b. Cost: O(n) for facets of similar size (uniform grid); parallel.
std::vector<FacetIntersection> facet_intersections(const std::vector<Vec3>& points,
                                                   const std::vector<std::array<int, 3>>& facets,
                                                   const std::vector<std::array<int, 3>>& joined,
                                                   const std::vector<int>& surface_of, double near);

/// Boundary sides: sides that no other facet of the same surface shares, as (facet, side),
/// ascending. Side i runs from corner i to corner i + 1. Empty `surface_of`: all facets belong to
/// one surface. Cost: O(n log n).
std::vector<std::pair<int, int>> boundary_sides(const std::vector<std::array<int, 3>>& facets,
                                                const std::vector<int>& surface_of = {});

}  // namespace batten
