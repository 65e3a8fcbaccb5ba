// SPDX-License-Identifier: MPL-2.0
// Selects the loops that become surfaces, and finds ambiguous selections and open boundaries.
#pragma once

#include <optional>

#include "batten/skinning/search/loop_selection.h"
#include "batten/skinning/search/region_loops.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// User specifications, resolved to loops of edges. They constrain the search.
struct FixedRegions {
  std::vector<std::vector<EdgeLoop>> requested;  ///< loops of each requested surface
  /// Sorted edges of each loop that must not become a surface.
  std::vector<std::vector<int>> excluded;
  int max_faces_per_edge = 2;  ///< RegionSearchOptions::max_faces_per_edge
};

/// Candidate loops, the selection problem and its solution.
struct RegionSearchResult {
  std::vector<LoopCandidate> loops;  ///< candidates with a positive gain, in canonical order
  LoopSelectionProblem problem;      ///< one item per candidate in `loops`
  /// Solution of `problem`: the selected candidates.
  LoopSelection selected;
  bool complete = true;  ///< false: tracing reached its work limit, loops may be missing
};

/// Traces loops, sets up the selection problem and solves it.
RegionSearchResult search_regions(const RegionGraph& graph, const FixedRegions& fixed_regions,
                                  const LoopCosts& costs, const Progress& progress);

/// Searches for a closed model if the search `open` has left free edges.
///
/// Each edge use gains more (LoopCosts::closed). Loops that look like free boundaries (mean
/// interior angle above 120°) are excluded unless they were selected before. `exact`: the same
/// graph with exact end tangents of the curves. Returns nothing if free edges remain, if the
/// candidates of `open` cannot cover all sides of the edges, if there are more than 2000 edges, or
/// if max_faces_per_edge is not 2.
std::optional<RegionSearchResult> search_closed_model(const RegionSearchResult& open,
                                                      const RegionGraph& exact,
                                                      const FixedRegions& fixed_regions,
                                                      const LoopCosts& costs,
                                                      const Progress& progress);

/// Searches for a closed model that uses all edges if the search `open` has left some unused, such
/// as the sharp edges of thin wedges and wings.
///
/// No fold costs more than one of 90°, unless the two surfaces lie on each other. Loops that were
/// not selected before must have the interior angles of planar ones. Returns nothing if free or
/// unused edges remain, if `open` has no unused edges, or if max_faces_per_edge is not 2.
std::optional<RegionSearchResult> search_sharp_model(const RegionSearchResult& open,
                                                     const RegionGraph& exact,
                                                     const FixedRegions& fixed_regions,
                                                     const LoopCosts& costs,
                                                     const Progress& progress);

/// Finds regions on a graph instead of a curve network; otherwise as find_regions(CurveNetwork).
FoundRegions find_regions(const RegionGraph& graph, const RegionSearchOptions& options = {},
                          const Progress& progress = {});

// Ambiguous selections.

/// Finds the selected loops that could be replaced at little extra cost.
///
/// `most`: largest loss of gain, relative to the gain per edge use (LoopCosts::covered) of the
/// loops concerned. Results are sorted by the selected loops, and the alternatives of each (at most
/// five) by loss.
std::vector<AmbiguousRegion> find_ambiguous_regions(const RegionGraph& graph,
                                                    const RegionSearchResult& search,
                                                    const LoopCosts& costs, double most = 0.15);

/// Lists each closed chain of free edges (`free_edges`: edges with one region) that a surface could
/// close.
///
/// Skipped are chains whose surface would lie on its neighbours (mean fold angle above 150°),
/// chains that the user has excluded, and those that find_ambiguous_regions() lists already.
std::vector<AmbiguousRegion> closable_free_edges(const RegionGraph& graph,
                                                 const RegionSearchResult& search,
                                                 const std::vector<NetworkRegion>& regions,
                                                 const std::vector<int>& free_edges,
                                                 const std::vector<std::vector<int>>& excluded,
                                                 const LoopCosts& costs);

/// Sets `edges` and `where` of an ambiguous region from its loops.
void locate_ambiguous_region(const RegionGraph& graph, AmbiguousRegion& ambiguous);
/// Formats loops for messages: "['a', 'b'], ['c', 'd']" for loops with the edges a, b and c, d. For
/// a loop of more than six edges: the first three names and the count.
std::string loops_as_text(const RegionGraph& graph, const std::vector<EdgeLoop>& loops);

}  // namespace batten
