// Facets of many surfaces that pass through each other.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Two facets, a < b, and a point that both have.
struct FacetCrossing {
  int a, b;
  Vec3 where;
};

/// Pairs of facets that pass through each other: an edge of one pierces the other, or both lie in
/// one plane and overlap. `facets`: the points of each; `joined`: the same with one index for
/// points that count as one wherever they lie. Pairs that have a point in common by that index are
/// none; nor are pairs that cross only within `near` of free edges of both (edges with one facet),
/// where two surfaces meet along a line that each follows in its own steps. Facets of area zero
/// cross nothing. Ordered by a, then b. O(n) for facets of similar size, by a grid of cells.
std::vector<FacetCrossing> facet_crossings(const std::vector<Vec3>& points,
                                           const std::vector<std::array<int, 3>>& facets,
                                           const std::vector<std::array<int, 3>>& joined,
                                           const std::vector<int>& surface_of, double near);

}  // namespace batten
