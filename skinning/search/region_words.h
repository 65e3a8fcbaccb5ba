// Turns what the user says about regions into loops of arcs.
#pragma once

#include "batten/skinning/search/region_search.h"

namespace batten {

/// What the user's words ask for, as loops.
struct SpokenRegions {
  SettledRegions settled;
  std::vector<NetworkRegion> regions;  ///< those asked for, in the order of the words
};

/// Finds the arcs of each name and chains them into loops. Throws InputError: a name that is not
/// there (with the nearest one), arcs that do not close one loop, a ring without two rims, an inner
/// line that is also a border, one loop said twice or to be both a surface and none, more regions
/// on an arc than `most_at_arc`.
SpokenRegions resolved_words(const RegionGraph& graph, const RegionOptions& options);

}  // namespace batten
