// Chooses the loops that are taken as surfaces from all that were traced.
#pragma once

#include <optional>

#include "batten/skinning/search/region_loops.h"
#include "batten/skinning/search/region_selection.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// What the user's words decide before the search.
struct SettledRegions {
  std::vector<std::vector<ArcLoop>> asked;  ///< the loops of each surface that the user asked for
  std::vector<std::vector<int>> nothing;    ///< arcs of loops that are no surface, ascending
  int most_at_line = 2;                     ///< RegionOptions::most_at_line
};

/// What was traced and chosen.
struct RegionSearch {
  std::vector<LoopCandidate> loops;  ///< those that gain by themselves, in canonical order
  Selection problem;                 ///< an item for each of `loops`
  Selected selected;
  bool complete = true;  ///< all loops were traced; false: the work limit was met
};

/// Traces loops, makes the problem of choosing among them, and solves it.
RegionSearch search_regions(const RegionGraph& graph, const SettledRegions& settled,
                            const LoopPrices& prices, const Progress& progress);

/// Searches for a closed model where the search has left rims: a loop is worth more for every side
/// that it covers (LoopPrices::closed), and loops that run like rims (mean inside angle above 120
/// degrees), which were not chosen, stay out. `exact`: the same graph with the curves' own tangents.
/// Returns nothing where rims are left, or would be by the loops that `open` knows.
std::optional<RegionSearch> closed_search(const RegionSearch& open, const RegionGraph& exact,
                                          const SettledRegions& settled, const LoopPrices& prices,
                                          const Progress& progress);

/// Searches for a closed model that takes all arcs where the choice has left some bare, as the sharp
/// edges of thin wedges and wings: an edge of any angle costs no more than one of 90 degrees there,
/// unless its surfaces lie on each other, and loops that were not chosen have to have the inside
/// angles of plane ones. Returns nothing where rims or bare arcs are left.
std::optional<RegionSearch> sharp_search(const RegionSearch& open, const RegionGraph& exact,
                                         const SettledRegions& settled, const LoopPrices& prices,
                                         const Progress& progress);

/// Does the same as find_regions() of a network, on a graph.
FoundRegions find_regions(const RegionGraph& graph, const RegionOptions& options = {},
                          const Progress& progress = {});

}  // namespace batten
