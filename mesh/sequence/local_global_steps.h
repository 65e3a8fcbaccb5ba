// SPDX-License-Identifier: MPL-2.0
// Local step and global right-hand side of the ARAP iteration over the one-rings of all nodes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

// Graph of nodes and edges for the ARAP iteration.

/// Edges between the nodes of a mesh, each once. At a non-manifold edge the one-rings of all
/// patches are merged.
struct NodeGraph {
  struct Edge {
    int a, b;
    double weight;
  };
  int nodes = 0;
  std::vector<Edge> edges;
  /// Neighbours of node i: start[i] … start[i + 1] - 1, ascending.
  std::vector<int> start, neighbour;
  std::vector<double> weight;  ///< w_ij of each entry of `neighbour`

  /// Neighbours of a node, ascending.
  std::span<const int> neighbours(int node) const {
    return {neighbour.data() + start[node], static_cast<size_t>(start[node + 1] - start[node])};
  }
};

/// Builds the node graph of a mesh. `weights`: one per edge of the topology; empty: 1 each. Weights
/// of edges between the same two nodes are added.
NodeGraph node_graph(const MeshTopology& topology, const std::vector<double>& weights = {});

/// Entries of the lower triangle of Σ w_ij (x_i - x_j)² over the nodes, each edge once.
std::vector<Triplet> laplacian_entries(const NodeGraph& graph);

/// Local step: fits R_i for all nodes except those with `is_prescribed` set (empty: none), by
///
///     M_i = Σ_j w_ij (v_j - v_i)(p_j - p_i)ᵀ,   R_i = nearest_rotation(M_i)
///
/// Returns the energy Σ_i Σ_j w_ij |(v_j - v_i) - R_i (p_j - p_i)|² with the rotations of all
/// nodes, prescribed ones included. It is computed as Σ w (|e|² + |e⁰|²) - 2 tr(R_iᵀ M_i). `parts`:
/// scratch memory, one partial sum per chunk. If all edges of a ring are collinear, R_i is not
/// unique; the one nearest to the previous rotation is taken. Parallel, with bit-identical results
/// for any number of threads.
double local_step(const NodeGraph& graph, const RowPoints& rest, const RowPoints& now,
                  const std::vector<char>& is_prescribed, std::vector<Mat3>& rotations,
                  std::vector<double>& parts);

/// Right-hand side of the global step for displacements x = v - p. The entry of node i is
///
///     Σ_j w_ij [½ (R_i + R_j) - 1] (p_i - p_j)
void global_step_rhs(const NodeGraph& graph, const RowPoints& rest,
                     const std::vector<Mat3>& rotations, RowPoints& loads);

// Volume enclosed by a closed surface.

/// V = 1/6 Σ p_a · (p_b × p_c) over triangles given by nodes.
double enclosed_volume(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p);
/// ∂V/∂p, nodes × 3.
void volume_gradient(const std::vector<std::array<int, 3>>& triangles, const RowPoints& p,
                     RowPoints& gradient);

}  // namespace batten
