// Finds facets of many surfaces that pass through each other.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

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
