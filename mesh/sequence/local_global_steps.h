// The two halves of a round of the alternation, over the rings of all nodes. Internal.
#pragma once

#include <vector>
#include <span>
#include <array>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Nodes and the edges between them, as the alternation sees a mesh. Internal.

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


/// R_i of all nodes for which `is_prescribed` is empty or 0, from
///
///     M_i = Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ,   R_i = nearest_rotation(M_i)
///
/// and the energy Σ_i Σ_j w_ij |(v_j - v_i) - R_i (p_j - p_i)|² with the rotations of all nodes, the
/// kept ones too, as Σ w (|e|² + |e⁰|²) - 2 tr(R_iᵀ M_i). `parts`: scratch of the sum, one number a
/// chunk. A ring whose edges lie on one line leaves R_i undetermined: it gets the nearest to the
/// rotation it had. In parallel; the same bits on any number of threads.
double local_step(const NodeGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& is_prescribed, std::vector<Mat3>& rotations,
                  std::vector<double>& parts);

/// Right side of the linear step for displacements x = v - p: of node i
///
///     Σ_j w_ij [½ (R_i + R_j) - 1] (p_i - p_j)
void global_step_rhs(const NodeGraph& graph, const RowPoints& rest,
                     const std::vector<Mat3>& rotations, RowPoints& loads);


// Volume that a closed surface encloses. Internal.

/// V = 1/6 Σ p_a · (p_b × p_c), of nodes.
double enclosed_volume(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p);
/// ∂V/∂p, nodes × 3.
void volume_gradient(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p,
                     RowPoints& gradient);

}  // namespace batten
