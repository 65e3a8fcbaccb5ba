// Inside of skin_network(): decides which way the normals of a network's regions point.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// One use of an arc by a region. `reversed`: the region's loop runs against the arc.
struct EdgeUse {
  int region = 0;
  bool reversed = false;
};

/// Regions whose normals hang together: each arc between two of them has no third.
struct OrientedPatch {
  std::vector<int> regions;
  bool closed = true;      ///< every arc has two uses
  bool orientable = true;  ///< the normals agree across all of them
};

/// What was found while the regions were turned.
struct Orientation {
  std::vector<ModelShell> shells;           ///< without area and volume
  std::vector<OrientedPatch> patches;       ///< the parts of shells that branch; else the shells
  std::vector<std::vector<EdgeUse>> sides;  ///< uses of each arc, regions ascending
  std::vector<double> filling_areas;        ///< area of the loops' plain filling; 0: unknown
  std::vector<double> sizes;                ///< diagonal of the box of each region's loops
};

/// Turns the loops of each region so that they run around it (holes against the outline, the rims
/// of a ring against each other), and the regions so that normals agree across every arc with two
/// regions: each such arc is then used once in either direction. To which side the normals of a
/// sheet point is a guess by plain fillings of the loops after the rule of normal_side.h, for which
/// the finished surfaces have the last word (RegionMaker::orient_normals()). A sheet that is
/// one-sided keeps its loops where they are in conflict. Cost: one plain filling of each loop, on
/// all threads.
Orientation orient(const CurveNetwork& network, std::vector<NetworkRegion>& regions);

/// Turns a region over: its loops, and its uses of arcs.
void flip_region(int region, NetworkRegion& plan, Orientation& orientation);

}  // namespace batten
