// What is solved for in a frame: nodes, rigid parts, and what is held. Internal.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/sequence/frame_constraints.h"
#include "batten/mesh/sequence/local_global_steps.h"
#include "batten/mesh/deform/deform_system.h"

namespace batten {

/// Displacements of all nodes are x_i = y_u(i) + o_i: y the unknowns, o an offset that only nodes of
/// rigid parts (the turn about their centre) and held ones (where they are) have.
struct FrameUnknowns {
  /// Nodes that move as one rigid body: a feature, or a handle that is held.
  struct RigidPart {
    std::string name;
    std::vector<int> nodes;
    int handle = -1;         ///< whose place is told, or -1
    int unknown = -1;        ///< of its centre's displacement; -1: held
    bool may_rotate = true;  ///< false: a feature that keeps its direction
    std::vector<int> edges;  ///< of the graph, that leave it
  };
  /// A node of a handle that is drawn to its place, not held there.
  struct PenalizedNode {
    int node, handle;
  };
  std::vector<int> unknown_of_node;  ///< u(i), or -1
  int count = 0;
  std::vector<RigidPart> parts;
  std::vector<int> part_of_node;               ///< or -1
  std::vector<PenalizedNode> penalized_nodes;  ///< empty without softness
  std::vector<int>
      offset_edges;  ///< edges of the graph with an offset at an end and an unknown at one
  std::vector<std::string> notes;  ///< about what nothing holds
  struct Shared {
    int node, one, other;  ///< a node of two handles
  };
  std::vector<Shared> shared;
};

FrameUnknowns frame_unknowns(const NodeGraph& graph, const FrameConstraints& constraints);

/// The matrix of the linear step, lower triangle: Σ w_ij (x_i - x_j)² + s Σ x_h² over the unknowns,
/// each edge once.
SparseMatrix frame_matrix(const NodeGraph& graph, const FrameUnknowns& unknowns,
                          double penalty_weight);


// Turns of handles, for solvers over all nodes and over few. Internal.

/// The mean of nodes; zero for none.
Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p);

/// The rotation that takes nodes about `from` best to where they are about `to`. `before`: the one they
/// had; where nothing tells, they turn no further.
Mat3 best_rotation(const std::vector<int>& nodes, const RowPoints& rest, const Vec3& from,
                   const RowPoints& now, const Vec3& to, const Mat3& before);

/// R of every node: the logarithms of the handles' turns, summed by its shares of them (nodes ×
/// handles).
void spread_rotations(const MatX& handle_weights, const std::vector<HandlePose>& handles,
                      std::vector<Mat3>& rotations);

}  // namespace batten
