// Inside of skin_network(): decides which way the normals of a network's regions point.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// One use of an arc by a region. `reversed`: the region's loop runs against the arc.
struct ArcSide {
  int region = 0;
  bool reversed = false;
};

/// What was found while the regions were turned.
struct Orientation {
  std::vector<ModelShell> shells;           ///< without area and volume
  std::vector<std::vector<ArcSide>> sides;  ///< uses of each arc, regions ascending
  std::vector<double> plain_areas;          ///< area of the loops' plain filling; 0: unknown
  std::vector<double> sizes;                ///< diagonal of the box of each region's loops
};

/// Turns the loops of each region so that they run around it (holes against the outline, the rims
/// of a ring against each other), and the regions so that normals agree across every arc with two
/// regions: each such arc is then used once in either direction. Normals of closed shells point
/// outwards (their plain filling encloses a positive volume), those of others up the z axis (or x,
/// or y, where that decides nothing). A shell that is one-sided or branches keeps its loops where
/// they are in conflict. Cost: one plain filling of each loop, on all threads.
Orientation orient(const CharacterLineNetwork& network, std::vector<NetworkRegion>& regions);

}  // namespace batten
