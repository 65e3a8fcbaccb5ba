// Nodes and the edges between them, as the alternation sees a mesh. Internal.
#pragma once

#include <span>
#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// The edges of a mesh between its nodes, each once: at a joint the rings of all sheets are one.
struct NodeGraph {
  struct Edge {
    int a, b;
    double weight;
  };
  int nodes = 0;
  std::vector<Edge> edges;
  std::vector<int> start, neighbour;  ///< of node i: start[i] … start[i + 1], ascending
  std::vector<double> weight;         ///< w_ij beside each neighbour

  std::span<const int> neighbours(int node) const {
    return {neighbour.data() + start[node], static_cast<size_t>(start[node + 1] - start[node])};
  }
};

/// `weights`: one for each edge of the topology; empty: 1 each. Edges between the same two nodes
/// add up.
NodeGraph node_graph(const MeshTopology& topology, const std::vector<double>& weights = {});

/// Entries of the lower triangle of Σ w_ij (x_i - x_j)² over the nodes, each edge once.
std::vector<Triplet> laplacian_entries(const NodeGraph& graph);

}  // namespace batten
