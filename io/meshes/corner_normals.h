// Normals with which viewers shade triangles. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Normals of the corners of triangles. Corners in one node have one normal where their triangles
/// hang together by edges across which they turn by less than the crease's angle; so a normal
/// belongs to one node.
struct CornerNormals {
  std::vector<Vec3> normals;           ///< unit vectors
  std::vector<std::array<int, 3>> of;  ///< the normal of each corner of each triangle
  std::vector<int> nodes;              ///< the node of each normal
};

/// Means of the triangles' normals, weighted by the angle at the node. Edges with other than two
/// triangles are creases. Where nothing has an area the normal is z. O(n log n).
CornerNormals corner_normals(const Points& points, const std::vector<std::array<int, 3>>& triangles,
                             double crease_deg = 30);

}  // namespace batten
