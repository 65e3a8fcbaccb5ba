// Takes found regions as rough surfaces, and finds which lines lie on them.
#pragma once

#include "batten/core/geometry.h"
#include "batten/skinning/search/region_loops.h"

namespace batten {

/// Triangles over the loop of a region: the plain hole filling, or a fan around the mean where
/// there is none.
class RoughSurface {
 public:
  RoughSurface(const RegionGraph& graph, const EdgeLoop& outline);
  double diagonal() const { return diagonal_; }
  /// Returns the distance of the farthest of the points from the triangles; infinity when it is
  /// above `enough`.
  double farthest(const std::vector<Vec3>& points, double enough) const;

 private:
  std::vector<std::array<Vec3, 3>> triangles_;
  Box3 box_;
  double diagonal_ = 0;
};

/// Gives bare arcs to the regions that they lie on (NetworkRegion::inner). These are arcs that
/// leave a node of the loop into the surface, or hang on such an arc, and stay nearer to its rough
/// surface than a tenth of the region's size, but not nearer to its border than a hundredth all
/// along.
void find_inner_lines(const RegionGraph& graph, const LoopCosts& costs,
                      std::vector<NetworkRegion>& regions);

/// Gives arcs whose curve is stated to lie inside, or to bound a hole, to the region whose rough
/// surface they are nearest to: within a tenth of its size. Holes are closed chains of such arcs.
/// Throws InputError for one that lies on no region, or does not close.
void assign_stated_inner_lines(const RegionGraph& graph, std::vector<NetworkRegion>& regions);

/// A loop by itself that lies on the rough surface of a region of another part, within a fiftieth
/// of that region's size.
struct Island {
  int region, on;  ///< indices of regions
};
/// Finds all islands.
std::vector<Island> find_islands(const RegionGraph& graph,
                                 const std::vector<NetworkRegion>& regions);

/// Returns the closed chains of some arcs, where no other of these arcs joins them; no arc is taken
/// twice.
std::vector<EdgeLoop> closed_chains(const RegionGraph& graph, const std::vector<int>& edges);

/// A closed chain of arcs with one region each, that lies inside of a plane region and in its plane
/// (3e-4 of the network's size): what stands on it, or goes through, has made a hole there.
struct PlanarHole {
  EdgeLoop loop;
  int on;  ///< index of the plane region; the smallest around the chain
};
/// Finds all of these, on regions that nobody asked for. `free_edges`: the arcs with one region.
std::vector<PlanarHole> find_planar_holes(const RegionGraph& graph,
                                          const std::vector<NetworkRegion>& regions,
                                          const std::vector<int>& free_edges);

/// Returns whether two loops are like the rims of a tube or an annulus: they have no corner of more
/// than 35 degrees, their planes differ by at most 60 degrees, and they are not side by side.
bool are_boundary_circles(const RegionGraph& graph, const EdgeLoop& a, const EdgeLoop& b);

}  // namespace batten
