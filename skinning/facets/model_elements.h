// Conforming quadratic elements of a whole model: regions that share a line share its nodes.
//
// Two regions share a line if one line of each (edge-aligned or embedded) has the same name. It is
// then the same curve in space, whatever its direction and parametrisation in each region. A point
// on it is identified by its fraction f of the parameter range,
//
//      f = (t - t0) / (t1 - t0)   along the first region's curve; others may run against it.
//
// Edges on a line end at the same fractions in all adjacent regions. These are the vertices of the
// regions in which it is edge-aligned or, if there are none, the subdivision of the first region.
// If a region needs more points (lines that meet there, triangles that would fold), the others get
// them too: regions are meshed again until none needs more. Edge midpoints are at the middle of the
// parameter interval, and therefore shared as well.
//
// Nodes are not merged by distance, with one exception: ends of lines that are closer than 1e-6 of
// the model's size become one node.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/skinning/facets/facets.h"

namespace batten {

/// The elements of all regions, with common node numbers.
struct ModelElements {
  /// The elements of each region, with the region's own node numbers.
  std::vector<QuadraticElements> regions;
  /// For each region and each of its nodes: the node number in the model, from 0, in the order of
  /// first occurrence.
  std::vector<std::vector<int>> node;
  /// Position of each node of the model, on the surface. A node of several regions has the position
  /// of the first region in which its line is edge-aligned, which is exactly on the line. If the
  /// line is embedded in all regions, it is the point of the first region's curve.
  std::vector<Vec3> positions;
  struct Line {
    std::string name;
    /// Node numbers of each edge, listed once: first end, second end, midpoint.
    std::vector<std::array<int, 3>> edges;
  };
  std::vector<Line> lines;  ///< one per name, in the order of first occurrence
};

/// Computes the elements of a model. Target lengths are as in quadratic_elements(), per region. A
/// model of one region has that region's own elements and numbers. It is as fast as
/// quadratic_elements() if all shared lines are edge-aligned; otherwise regions with embedded lines
/// are meshed about twice.
///
/// Throws InputError for an empty list; lines of one name that are not the same curve (farther
/// apart than 1e-2 of the smaller region's size); neighbours for which no common subdivision is
/// found; and as quadratic_elements() does.
ModelElements model_elements(const std::vector<const SkinnedRegion*>& regions,
                             double edge_length = 0);

}  // namespace batten
