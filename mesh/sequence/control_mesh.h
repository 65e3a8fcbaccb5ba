// Control meshes: coarse closed meshes around a mesh, mean value coordinates, and transfer to other
// frames.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of control_mesh().
struct ControlMeshOptions {
  int vertices = 150;      ///< approximate number of vertices, 20 to 2000
  double distance = 0.02;  ///< minimum distance from the mesh, relative to its size, 0.001 to 0.5
};

/// Builds a closed mesh that encloses all triangles of `mesh`, which may be open. Uses CGAL's alpha
/// wrap; alpha is found by trial to give about `options.vertices` vertices. Throws InputError
/// (options out of range, no triangles, or a build without CGAL; supply your own control mesh then)
/// or NoSolutionError (no alpha gives so few vertices). Takes a second for 30,000 triangles.
TriangleMesh control_mesh(const TriangleMesh& mesh, const ControlMeshOptions& options = {});

/// Mean value coordinates W of points (points × vertices) with respect to a closed mesh:
///
///     x = Σ_j W_j d_j,   Σ_j W_j = 1
///
/// This holds for every x, inside or outside. An affine motion of the vertices d moves x by the
/// same motion. On a face they equal its barycentric coordinates. Throws InputError if the mesh is
/// not closed. O(points · triangles), about 0.1 µs per pair, in parallel. Source:
/// [JuSchaeferWarren2005], figure 4.
MatX mean_value_coordinates(const TriangleMesh& control, const Points& points);

/// Transfers a control mesh to other frames. Each control vertex d is expressed in the local frames
/// of the `near` nodes with the largest coordinates W for it. Its position in frame k is the mean
/// of what these local frames give:
///
///     d^k = mean_b [ p_b^k + R_b^k (d - p_b) ]
///
/// p are the nodes of `mesh`, at which W was computed (nodes × control vertices). R_b^k is the
/// rotation of the one-ring of node b from there to frame k. Rigid motions are reproduced exactly.
/// Source: [Xu2007], section on control meshes.
class ControlMeshTransfer {
 public:
  /// `near`: number of nodes per control vertex, default 4.
  ControlMeshTransfer(const TriangleMesh& mesh, const Points& control, const MatX& W, int near = 4);
  /// Positions of the control vertices for a frame (nodes × 3). Throws InputError if the number of
  /// nodes differs.
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
