// Chooses the loops that are taken as surfaces from all that were traced.
#pragma once

#include <optional>

#include "batten/skinning/search/loop_selection.h"
#include "batten/skinning/search/region_loops.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// What the user's words decide before the search.
struct FixedRegions {
  std::vector<std::vector<EdgeLoop>>
      requested;                           ///< the loops of each surface that the user asked for
  std::vector<std::vector<int>> excluded;  ///< arcs of loops that are no surface, ascending
  int max_faces_per_edge = 2;              ///< RegionSearchOptions::max_faces_per_edge
};

/// What was traced and chosen.
struct RegionSearchResult {
  std::vector<LoopCandidate> loops;  ///< those that gain by themselves, in canonical order
  LoopSelectionProblem problem;      ///< an item for each of `loops`
  LoopSelection selected;
  bool complete = true;  ///< all loops were traced; false: the work limit was met
};

/// Traces loops, makes the problem of choosing among them, and solves it.
RegionSearchResult search_regions(const RegionGraph& graph, const FixedRegions& fixed_regions,
                                  const LoopCosts& costs, const Progress& progress);

/// Searches for a closed model where the search has left rims: a loop is worth more for every side
/// that it covers (LoopCosts::closed), and loops that run like rims (mean inside angle above 120
/// degrees), which were not chosen, stay out. `exact`: the same graph with the curves' own tangents.
/// Returns nothing where rims are left, or would be by the loops that `open` knows.
std::optional<RegionSearchResult> search_closed_model(const RegionSearchResult& open,
                                                      const RegionGraph& exact,
                                                      const FixedRegions& fixed_regions,
                                                      const LoopCosts& costs,
                                                      const Progress& progress);

/// Searches for a closed model that takes all arcs where the choice has left some bare, as the sharp
/// edges of thin wedges and wings: an edge of any angle costs no more than one of 90 degrees there,
/// unless its surfaces lie on each other, and loops that were not chosen have to have the inside
/// angles of plane ones. Returns nothing where rims or bare arcs are left.
std::optional<RegionSearchResult> search_sharp_model(const RegionSearchResult& open,
                                                     const RegionGraph& exact,
                                                     const FixedRegions& fixed_regions,
                                                     const LoopCosts& costs,
                                                     const Progress& progress);

/// Does the same as find_regions() of a network, on a graph.
FoundRegions find_regions(const RegionGraph& graph, const RegionSearchOptions& options = {},
                          const Progress& progress = {});


// Finds choices that could as well have been made otherwise.

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
