// SPDX-License-Identifier: MPL-2.0
// Rotations of the nodes of a finite-element mesh between two shapes, from the elements around them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Rotations of the nodes of a mesh between the shapes `before` and `after`. They turn what is
/// attached to nodes, but is stored as numbers: nodal normals, section directions, local axes.
///
/// Let the ring of a node be the nodes of all its elements. The best-fitting rotation of a ring
/// belongs to its centroid, which at an edge of the mesh is not the node. With the centroids c_j
/// and rotations R_j of the rings of the nodes j around node i at the position x_i, the rotation of
/// the node is
///
///     R = exp(G (x_i - c_i)) R_i,    min over G: Σ_j |log(R_j R_iᵀ) - G (c_j - c_i)|²
///
/// The extrapolation is exact to second order for bending. If all nodes of a ring lie on a line, the
/// ring is extended by the elements around it; on a straight line of elements, the rotation is the
/// smallest one between the two lines. Rigid motions are reproduced to rounding.
class NodeRotations {
 public:
  /// Keeps references to the shapes (n×3 each). O(elements).
  NodeRotations(const ShellMesh& shells, std::span<const NonShellElement> elements,
                const Points& before, const Points& after);

  /// Motion of a group of nodes: x → R x + translation.
  struct Motion {
    Mat3 R = Mat3::Identity();
    Vec3 translation = Vec3::Zero();
    double spread = 0;        ///< largest angle between R and the rotation of one of the nodes
    bool is_identity = true;  ///< no node around the group has moved
    bool is_rotated = false;  ///< the angle of R is above rounding errors
  };
  /// Mean rotation of the nodes, and the translation of their mean. No nodes: the identity.
  Motion of(std::span<const int> nodes) const;

 private:
  struct Ring {
    Vec3 centroid;
    Mat3 R;
    bool moved;
    double extent;  // largest distance from the centroid
  };
  std::vector<int> nodes_around(std::vector<int> nodes) const;
  Ring ring_of(int node) const;
  const Mat3& rotation_at(int node, const Ring& own) const;
  Mat3 extrapolated_rotation(int node, const Ring& own) const;
  double rounding_angle(double extent) const;

  const Points& before_;
  const Points& after_;
  double largest_ = 0;                    // largest absolute coordinate
  std::vector<int> start_, elements_of_;  // elements of each node
  std::vector<std::vector<int>> elements_;
  // Computed when needed.
  mutable std::vector<std::optional<Ring>> rings_;
  mutable std::vector<std::optional<Mat3>> rotations_;
};

}  // namespace batten
