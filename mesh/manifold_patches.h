// Triangles of any shells as sheets that are manifolds. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Sheets as prepare() says: which faces go on past a joint, and where a sheet with one side is cut.
struct ManifoldPatches {
  std::vector<std::array<int, 3>> triangles;  ///< by vertices, neighbours running opposite ways
  std::vector<int> duplicate_vertex_nodes;    ///< node of each vertex beyond the nodes
  std::vector<char> flipped;                  ///< triangles that run the other way than they did
  int count = 0;                              ///< sheets
  int component_count = 0;                    ///< parts that have no node in common
  int cut_edges = 0;                          ///< where sheets with one side were cut open
  std::vector<std::array<int, 2>> non_manifold_edges;  ///< of three triangles or more
  std::vector<int> non_manifold_nodes;                 ///< where sheets meet, at no end of a joint

  /// A triangle by its nodes.
  std::array<int, 3> nodes_of(std::array<int, 3> triangle) const;
  int vertex_count = 0;
};

/// Triangles by nodes, no corner twice. O(triangles · log triangles).
ManifoldPatches find_manifold_patches(const Points& points,
                                      std::vector<std::array<int, 3>> triangles);

}  // namespace batten
