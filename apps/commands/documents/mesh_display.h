// Display points of an edited mesh.
#pragma once

#include <memory>
#include <vector>

#include "batten/mesh/triangle_mesh.h"
#include "batten/sculpting/session/session_results.h"

namespace batten {

/// Turns shapes of one mesh into frames. A vertex where the mesh has a crease stands for several
/// display points, each with a normal of its own; that is decided once, on the mesh as it was read.
class MeshDisplay {
 public:
  /// `lines`: chains of vertices that are drawn. O(triangles · log triangles).
  MeshDisplay(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines);

  /// Fills a frame with a shape (n×3). O(triangles), allocates nothing once the frame has its size.
  void draw(const Points& shape, Frame& frame) const;
  const std::vector<int>& vertices() const { return vertices_; }  ///< of each display point

 private:
  std::shared_ptr<const DisplayTopology> pattern_;
  std::vector<int> vertices_;
};

}  // namespace batten
