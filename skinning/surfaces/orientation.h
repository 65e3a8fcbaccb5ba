// SPDX-License-Identifier: MPL-2.0
// Orients the regions of a network consistently, and groups them into shells.
#pragma once

#include <vector>

#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// The use of a network edge by a region. `reversed`: the region's loop runs against the edge.
struct EdgeUse {
  int region = 0;  ///< index of the region
  bool reversed = false;
};

/// Regions with a common orientation: a connected set, across edges with exactly two regions.
struct OrientedPatch {
  std::vector<int> regions;  ///< indices, ascending
  bool closed = true;        ///< every edge has two uses
  bool orientable = true;    ///< consistent normals exist across all its edges
};

/// Result of orient().
struct Orientation {
  std::vector<ModelShell> shells;  ///< connected components of regions; area and volume are not set
  /// Manifold parts of non-manifold shells; otherwise the shells.
  std::vector<OrientedPatch> patches;
  /// For each edge, its uses by regions, in ascending order of regions.
  std::vector<std::vector<EdgeUse>> sides;
  /// Area of the hole-filling triangulation per region, model units²; 0: unknown.
  std::vector<double> filling_areas;
  std::vector<double> sizes;  ///< bounding-box diagonal of each region's loops, model units
};

/// Orients the loops and regions of a network, and finds its shells.
///
/// `regions`: the regions that were found in `network`; loops are reversed in place.
///
/// The loops of each region are oriented to run around it: holes against the outer loop, the two
/// boundary circles of an annulus against each other. Regions are then oriented so that normals
/// agree across every edge with two regions; each such edge is used once in either direction. The
/// side to which the normals of a patch point is estimated from hole-filling triangulations of the
/// loops, by the rules of normal_side.h. The finished surfaces decide finally
/// (RegionMaker::orient_normals()). A non-orientable patch keeps its loops at conflicting edges.
///
/// Throws nothing of its own: a loop without a hole-filling triangulation is sketched by a fan, and
/// its filling area is 0. Cost: one hole-filling triangulation per loop; parallel.
Orientation orient(const CurveNetwork& network, std::vector<NetworkRegion>& regions);

/// Reverses the orientation of a region: its loops and its edge uses.
///
/// `region`: index of the region; `plan`: the region itself, whose loops are reversed;
/// `orientation`: the result of orient(), whose `sides` follow. O(edges of the region).
void flip_region(int region, NetworkRegion& plan, Orientation& orientation);

}  // namespace batten
