// Coarse closed meshes around a mesh, and how it follows them.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct ControlMeshOptions {
  int vertices = 150;      ///< about as many as it should have, 20 to 2000
  double distance = 0.02;  ///< from the mesh, of its size, at least
};

/// A closed mesh that encloses all triangles of `mesh`, open or not, in about as many vertices as
/// asked: CGAL's alpha wrap, whose alpha is found by trials. Throws InputError: options out of
/// range, no triangles, or a build without CGAL (give a control mesh then); NoSolutionError where no
/// alpha gives so few vertices. A second for 30,000 triangles.
TriangleMesh control_mesh(const TriangleMesh& mesh, const ControlMeshOptions& options = {});

/// Mean value coordinates W of points, points × vertices of a closed mesh:
///
///     x = Σ_j W_j d_j,   Σ_j W_j = 1
///
/// for every x, inside or outside; what moves the vertices affinely moves x so. On a face they are
/// its barycentric coordinates. Throws InputError when the mesh is not closed. O(points · triangles),
/// about 0.1 µs each, in parallel. Source: Ju, Schaefer, Warren 2005, figure 4.
MatX mean_value_coordinates(const TriangleMesh& control, const Points& points);

/// The control mesh in other frames: each vertex d keeps its places in the local frames of the
/// `near` nodes whose W from it is largest, and takes the mean of what they say:
///
///     d^k = mean_b [ p_b^k + R_b^k (d - p_b) ]
///
/// p, `mesh`: where W was taken (nodes × control vertices); R_b^k: rotation of a node's ring from
/// there to frame k. A rigid motion moves it exactly. Source: Xu et al. 2007, section on control
/// meshes.
class ControlMeshTransfer {
 public:
  ControlMeshTransfer(const TriangleMesh& mesh, const Points& control, const MatX& W, int near = 4);
  /// Control vertices at a frame (nodes × 3). Throws InputError on another number of nodes.
  Points at(const Points& frame) const;

 private:
  struct Link {
    int node;
    Vec3 offset;  // d - p_b
  };
  const TriangleMesh mesh_;
  std::vector<std::vector<Link>> links_;  // of each control vertex
  std::vector<int> nodes_;                // that are looked at
};

}  // namespace batten
