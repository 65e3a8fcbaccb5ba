// Display points of an edited mesh.
#pragma once

#include <memory>
#include <vector>

#include "batten/mesh/triangle_mesh.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

/// Converts shapes of a mesh to frames. A vertex on a crease has several display points with
/// separate normals. Creases are determined once, on the undeformed mesh.
class MeshDisplay {
 public:
  /// `lines`: vertex chains to draw. Cost: O(triangles · log triangles).
  MeshDisplay(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines);

  /// Fills a frame with a shape (n×3). Cost: O(triangles); no allocation once the frame has its
  /// size.
  void draw(const Points& shape, Frame& frame) const;
  const std::vector<int>& vertices() const { return vertices_; }  ///< vertex of each display point

 private:
  std::shared_ptr<const DisplayTopology> pattern_;
  std::vector<int> vertices_;
};

}  // namespace batten
