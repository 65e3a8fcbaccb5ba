// SPDX-License-Identifier: MPL-2.0
// Approximates regions by triangulated surfaces, to find inner edges, holes and islands.
#pragma once

#include "batten/core/geometry.h"
#include "batten/skinning/search/region_loops.h"

namespace batten {

/// A coarse triangulation that spans the loop of a region: hole-filling triangulation [Liepa2003],
/// or a fan around the mean of the points if there is none.
class RoughSurface {
 public:
  RoughSurface(const RegionGraph& graph, const EdgeLoop& outline);
  /// Diagonal of the bounding box of the loop, model units.
  double diagonal() const { return diagonal_; }
  /// Largest distance of the points from the triangles; infinity if it exceeds `enough`.
  double farthest(const std::vector<Vec3>& points, double enough) const;

 private:
  std::vector<std::array<Vec3, 3>> triangles_;
  Box3 box_;
  double diagonal_ = 0;
};

/// Assigns unused edges to the regions on which they lie (NetworkRegion::inner).
///
/// An edge is assigned if it leaves a node of the outer loop into the surface, or touches an inner
/// edge already assigned. It must stay within a tenth of the region's size of the coarse surface.
/// It must not stay within a hundredth of the size of the boundary along its whole length.
void find_inner_lines(const RegionGraph& graph, const LoopCosts& costs,
                      std::vector<NetworkRegion>& regions);

/// Assigns edges with the role Inner or Hole to the region with the closest coarse surface, within
/// a tenth of the region's size. If there is only one region, it gets them in any case. Holes are
/// closed chains of such edges. Throws InputError if an edge lies on no region or a hole does not
/// close.
void assign_stated_inner_lines(const RegionGraph& graph, std::vector<NetworkRegion>& regions);

/// A disconnected loop that lies on the coarse surface of a region of another component, within a
/// fiftieth of that region's size.
struct Island {
  int region, on;  ///< indices of the region of the loop, and of the region on which it lies
};
/// Finds all islands. Requested regions are not considered as islands.
std::vector<Island> find_islands(const RegionGraph& graph,
                                 const std::vector<NetworkRegion>& regions);

/// Closed chains of the given edges: at each node of a chain exactly two of these edge ends meet.
/// Each edge is used at most once.
std::vector<EdgeLoop> closed_chains(const RegionGraph& graph, const std::vector<int>& edges);

/// A closed chain of free edges inside a planar region and in its plane (within 3e-4 of the network
/// size): the outline of a part that stands there or passes through.
struct PlanarHole {
  EdgeLoop loop;
  int on;  ///< index of the planar region; the one of smallest area that contains the chain
};
/// Finds all planar holes, in regions that were not requested. `free_edges`: edges with one region.
std::vector<PlanarHole> find_planar_holes(const RegionGraph& graph,
                                          const std::vector<NetworkRegion>& regions,
                                          const std::vector<int>& free_edges);

/// True if two loops look like the boundary circles of a tube or an annulus. Neither has a corner
/// of more than 35°, their planes differ by at most 60°, and they are not side by side.
bool are_boundary_circles(const RegionGraph& graph, const EdgeLoop& a, const EdgeLoop& b);

}  // namespace batten
