// Finds choices that could as well have been made otherwise.
#pragma once

#include "batten/skinning/search/region_search.h"

namespace batten {

/// Returns the choices with alternatives that cost at most `most` more, relative to what the sides
/// of the arcs of their loops are worth. They are sorted by the chosen loops, the alternatives of
/// each (at most five) by what they cost.
std::vector<AmbiguousRegion> find_ambiguous_regions(const RegionGraph& graph,
                                                    const RegionSearchResult& search,
                                                    const LoopCosts& costs, double most = 0.15);

/// Returns a choice for each closed chain of arcs with one region (`free_edges`) that a surface could
/// close, unless that surface would lie on its neighbours (a fold above 150 degrees), the user has
/// refused it, or it is among the near choices.
std::vector<AmbiguousRegion> closable_free_edges(const RegionGraph& graph,
                                                 const RegionSearchResult& search,
                                                 const std::vector<NetworkRegion>& regions,
                                                 const std::vector<int>& free_edges,
                                                 const std::vector<std::vector<int>>& excluded,
                                                 const LoopCosts& costs);

/// Fills in the arcs and the place of a choice from its loops.
void locate_ambiguous_region(const RegionGraph& graph, AmbiguousRegion& ambiguous);
/// Returns "['a', 'b'], ['c', 'd']" for loops of the arcs a, b and c, d; of a loop of more than six
/// arcs only the first three names and the count.
std::string loops_as_text(const RegionGraph& graph, const std::vector<EdgeLoop>& loops);

}  // namespace batten
