// SPDX-License-Identifier: MPL-2.0
// Unknowns of a frame: nodes, rigid parts and constraints.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/sequence/frame_constraints.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {

/// Numbering of the unknowns. The displacement of node i is x_i = y_u(i) + o_i, with unknowns y and
/// offsets o. Only nodes of rigid parts (rotation about the centre) and constrained nodes
/// (prescribed displacement) have an offset.
struct FrameUnknowns {
  /// A group of nodes that moves as one rigid body: a feature, or a handle with hard constraints.
  struct RigidPart {
    std::string name;
    std::vector<int> nodes;
    int handle = -1;         ///< handle whose pose is prescribed, or -1
    int unknown = -1;        ///< unknown of the displacement of its centre; -1: prescribed
    bool may_rotate = true;  ///< false: a feature that keeps its direction
    std::vector<int> edges;  ///< edges of the graph that leave the part
  };
  /// A node of a handle with soft constraints (penalty).
  struct PenalizedNode {
    int node, handle;
  };
  std::vector<int> unknown_of_node;  ///< u(i), or -1
  /// Number of unknowns.
  int count = 0;
  std::vector<RigidPart> parts;
  std::vector<int> part_of_node;               ///< part of each node, or -1
  std::vector<PenalizedNode> penalized_nodes;  ///< empty for hard constraints
  std::vector<int>
      offset_edges;  ///< edges of the graph with an offset at one end and an unknown at one end
  std::vector<std::string> notes;  ///< about parts of the mesh without constraints
  struct Shared {
    int node, one, other;  ///< a node that belongs to two handles
  };
  std::vector<Shared> shared;
};

/// Numbers the unknowns of a graph with constraints.
FrameUnknowns frame_unknowns(const NodeGraph& graph, const FrameConstraints& constraints);

/// Matrix of the global step, lower triangle: Σ w_ij (x_i - x_j)² + s Σ x_h² over the unknowns.
/// Each edge counts once; s is `penalty_weight`, h runs over the penalised nodes.
SparseMatrix frame_matrix(const NodeGraph& graph, const FrameUnknowns& unknowns,
                          double penalty_weight);

// Rotations of handles, for the full and the subspace solver.

/// Centroid of nodes; zero if there are none.
Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p);

/// Fits the rotations of the handles whose poses leave them free, from the positions `rest`
/// relative to `centres` (one per handle) to `now` relative to the prescribed centres. Directions
/// that the nodes of a handle do not determine are not rotated further.
void fit_free_handles(const std::vector<Handle>& handles, const std::vector<HandlePose>& poses,
                      const RowPoints& rest, const std::vector<Vec3>& centres, const RowPoints& now,
                      std::vector<Mat3>& rotations);

/// Sets R of every node: interpolate_rotations() of the handle poses with `handle_weights` (nodes ×
/// handles).
void spread_rotations(const MatX& handle_weights, const std::vector<HandlePose>& handles,
                      std::vector<Mat3>& rotations);

}  // namespace batten
