// Makes conforming quadratic elements of a whole model: regions that share lines share the nodes on
// them.
//
// Two regions share a line where one line (run or embedded) of each has the same name; it is then
// the same curve in space, whatever way round and over whatever parameters each of them has it. A
// place on it is known by its fraction f of the parameter from start to end,
//
//      f = (t - t0) / (t1 - t0)  of the side that is listed first,  along or against it on others.
//
// Edges on a line end at the same fractions in all regions beside it: at the vertices of those that
// have it as a run; where nobody has, as the first region divides it. Where a region needs more
// ends (lines that meet there, triangles that would fold) the others get them too: regions are made
// again until none asks for more. Middles of edges are at the middle of their parameters and so are
// the same as well.
//
// Nodes are not searched for by distance, but for one case: lines meet at their ends, and ends that
// are nearer to each other than 1e-6 of the model's size are one node.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/facets/facets.h"

namespace batten {

/// The elements of all regions, whose nodes get common numbers.
struct ModelElements {
  /// The elements of each region, with node numbers of its own.
  std::vector<QuadraticElements> regions;
  /// For each region and each of its nodes the number in the model; numbers begin at 0, in the
  /// order in which nodes first come.
  std::vector<std::vector<int>> node;
  /// Place of each node of the model, on the surface. For a node of several regions it is that of
  /// the first one that has it on a run, which is exactly on the line; where all regions have the
  /// line embedded, it is the point of the first region's curve.
  std::vector<Vec3> positions;
  struct Line {
    std::string name;
    /// Nodes of the model on each edge, which is here once: first end, second end, middle.
    std::vector<std::array<int, 3>> edges;
  };
  std::vector<Line> lines;  ///< each name once, as they first come
};

/// Makes them. Target lengths are as in quadratic_elements(), for each region by itself. A model of
/// one region has that region's own facets and their numbers. As fast as quadratic_elements() where
/// all shared lines are runs; otherwise regions with embedded lines are meshed about twice.
///
/// Throws InputError: no region; lines of one name that are not the same curve (apart by more than
/// 1e-2 of the smaller region); neighbours whose facets do not settle; and what quadratic_elements()
/// throws.
ModelElements model_elements(const std::vector<const SkinnedRegion*>& regions,
                             double edge_length = 0);

}  // namespace batten
