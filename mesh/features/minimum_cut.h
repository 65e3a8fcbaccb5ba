// Minimum cut on the dual graph of a mesh, and the cost of its edges.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Cost of edges for cut_feature() and stroke_cut().

/// Options of cut_feature() and stroke_cut().
struct CutOptions {
  /// Weights η of concave edges (the surface bends towards its normals) and convex ones. The kind
  /// with the larger η attracts the cut. The two kinds are exchanged if the orientation of the mesh
  /// is reversed; swap the weights for a feature seen from its hollow side.
  double concave = 1, convex = 0.2;
  /// A vertex of the feature. -1: the feature is the side with the smaller area.
  int feature_vertex = -1;
};

/// An undirected edge of the dual graph; a and b are its nodes.
struct DualEdge {
  int a, b;
  double capacity;
};

/// Nodes on the source side of the minimum cut: one flag per node. The smallest such set is taken,
/// the nodes reachable from the source through residual capacity.
std::vector<char> source_side(int nodes, int source, int sink,
                              const std::vector<DualEdge>& graph_edges);

/// Cost of each of the given edges, which must have two triangles; the formula is at cut_feature().
std::vector<double> cut_capacities(const TriangleMesh& mesh, const std::vector<int>& edges,
                                   const CutOptions& options);

/// Throws InputError if an η is negative or not finite.
void check(const CutOptions& options);

}  // namespace batten
