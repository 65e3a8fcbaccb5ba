// SPDX-License-Identifier: MPL-2.0
// Control meshes (coarse closed meshes that enclose a mesh), mean value coordinates, and transfer
// of control meshes to other frames.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of control_mesh().
struct ControlMeshOptions {
  int vertices = 150;  ///< approximate number of vertices of the control mesh, 20 to 2000
  /// Minimum distance of the control mesh from the mesh, relative to the mesh size, 0.001 to 0.5.
  double distance = 0.02;
};

/// Builds a closed mesh that encloses all triangles of `mesh`, which may be open, by CGAL's alpha
/// wrapping. The parameter alpha is adjusted iteratively to give about `options.vertices` vertices.
/// Throws InputError if an option is out of range, the mesh has no triangles, or Batten was built
/// without CGAL (supply your own control mesh then), and NoSolutionError if no alpha gives about
/// the requested number of vertices. Takes one second for 30,000 triangles.
TriangleMesh control_mesh(const TriangleMesh& mesh, const ControlMeshOptions& options = {});

/// Mean value coordinates of points with respect to a closed mesh, as a matrix points × vertices.
/// The coordinates W_j of a point x and the vertices d_j of the mesh satisfy
///
///     x = Σ_j W_j d_j,   Σ_j W_j = 1
///
/// for every x, inside or outside the mesh. An affine transformation of all d_j moves x by the same
/// transformation. If x is on a face, W_j are the barycentric coordinates in this face. Throws
/// InputError if the mesh is not closed. O(points · triangles), about 0.1 µs per pair, in parallel.
/// Reference: [JuSchaeferWarren2005], figure 4.
MatX mean_value_coordinates(const TriangleMesh& control, const Points& points);

/// Transfers a control mesh from one frame (`mesh`) to the other frames of a sequence. Each control
/// vertex d is attached to the nodes b of `mesh` that have the largest mean value coordinates W
/// with respect to d. The position of d in frame k is the mean of the positions predicted by these
/// nodes:
///
///     d^k = mean_b [ p_b^k + R_b^k (d - p_b) ]
///
/// p_b is the position of node b in `mesh` and p_b^k its position in frame k. R_b^k is the rotation
/// of the one-ring of node b from `mesh` to frame k. Rigid motions are reproduced exactly.
/// Reference: [Xu2007], section on control meshes.
class ControlMeshTransfer {
 public:
  /// Attaches control vertices to nodes of `mesh`. `control`: positions of the control vertices.
  /// `W`: mean_value_coordinates() of the nodes of `mesh` (nodes × control vertices). `near`:
  /// number of nodes to which each control vertex is attached, default 4.
  ControlMeshTransfer(const TriangleMesh& mesh, const Points& control, const MatX& W, int near = 4);
  /// Positions of the control vertices in another frame. `frame`: node positions (nodes × 3).
  /// Throws InputError if the number of nodes differs from that of the mesh.
  Points at(const Points& frame) const;

 private:
  struct Link {
    int node;
    Vec3 offset;  // d - p_b
  };
  const TriangleMesh mesh_;
  std::vector<std::vector<Link>> links_;  // per control vertex
  std::vector<int> nodes_;                // nodes that occur in links_
};

}  // namespace batten
