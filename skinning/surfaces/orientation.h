// Inside of skin_network: which way the normals of a network's regions point.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// One use of an arc by a region: there when the loop runs along the arc, otherwise reversed.
struct ArcSide {
  int region = 0;
  bool reversed = false;
};

struct Orientation {
  std::vector<ModelShell> shells;           ///< without area and volume
  std::vector<std::vector<ArcSide>> sides;  ///< uses of each arc, regions ascending
  std::vector<double> plain_areas;          ///< area of the loops' plain filling; 0: unknown
  std::vector<double> sizes;                ///< diagonal of the box of each region's loops
};

/// Turns the loops of each region so that they run around it (holes against the outline, the rims
/// of a ring against each other), and regions so that normals agree across every arc with two
/// regions, where the shell lets them: then each arc is used once in either direction. Closed
/// shells point outwards (their plain filling encloses a positive volume), others up the z axis (or
/// x, or y, where that says nothing). A shell that is one-sided or branches keeps its loops where
/// they are in conflict. Cost: one plain filling of each loop, side by side.
Orientation orient(const CharacterLineNetwork& network, std::vector<NetworkRegion>& regions);

}  // namespace batten
