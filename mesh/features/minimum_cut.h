// The minimum cut between triangles and what its edges cost. Internal.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

// What attracts the cuts of feature_cut.h and stroke_cut.h.

struct CutOptions {
  /// η of edges where the surface bends towards its normals, and away from them. The one with the
  /// larger η attracts the cut. Which is which turns round with the mesh's orientation; for a
  /// feature seen from its hollow side swap them.
  double concave = 1, convex = 0.2;
  /// A vertex of the feature; -1: the feature is the side with the smaller area.
  int feature_vertex = -1;
};


/// An undirected edge of the dual graph.
struct DualEdge {
  int a, b;
  double capacity;
};

/// The nodes on the source's side of the minimum cut, as few as possible: those that residual
/// capacity reaches from the source.
std::vector<char> source_side(int nodes, int source, int sink,
                              const std::vector<DualEdge>& graph_edges);

/// Cost of each of these edges of the topology, which have two triangles: cut_feature() says how.
std::vector<double> cut_capacities(const TriangleMesh& mesh, const std::vector<int>& edges,
                                   const CutOptions& options);

/// Throws InputError when an η is negative or not finite.
void check(const CutOptions& options);

}  // namespace batten
