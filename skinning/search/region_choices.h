// What could as well have been chosen otherwise.
#pragma once

#include "batten/skinning/search/region_search.h"

namespace batten {

/// Choices whose alternatives cost less than `most` more, relative to what the sides of the arcs of
/// their loops are worth; sorted by the chosen loops, alternatives by what they cost.
std::vector<RegionChoice> near_choices(const RegionGraph& graph, const RegionSearch& search,
                                       const LoopPrices& prices, double most = 0.15);

/// One for each closed chain of arcs with one region (`rims`) that could be closed by a surface,
/// unless that would lie on its neighbours (fold beyond 150 degrees), or is said to be none.
std::vector<RegionChoice> rim_choices(const RegionGraph& graph, const RegionSearch& search,
                                      const std::vector<NetworkRegion>& regions,
                                      const std::vector<int>& rims,
                                      const std::vector<std::vector<int>>& nothing,
                                      const LoopPrices& prices);

/// Fills in the arcs and the place of a choice from its loops.
void place_choice(const RegionGraph& graph, RegionChoice& choice);
/// "['a', 'b'], ['c', 'd']" for loops of the arcs a, b and c, d.
std::string said(const RegionGraph& graph, const std::vector<ArcLoop>& loops);

}  // namespace batten
