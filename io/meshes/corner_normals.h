// SPDX-License-Identifier: MPL-2.0
// Corner normals for shading triangle meshes, broken at crease edges.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Shading normals per triangle corner. Corners at the same node share one normal if their
/// triangles are connected through edges whose dihedral angle is below the crease angle. Each
/// normal therefore belongs to exactly one node.
struct CornerNormals {
  std::vector<Vec3> normals;           ///< unit vectors
  std::vector<std::array<int, 3>> of;  ///< index into `normals`, per triangle and corner
  std::vector<int> nodes;              ///< node of each normal
};

/// Computes corner normals as averages of the triangle normals, weighted by the corner angle.
///
/// An edge between two consistently oriented triangles is smooth if their normals differ by less
/// than `crease_deg` (degrees). All other edges are creases, including those without exactly two
/// triangles. If all triangles of a corner group have zero area, the normal is the z axis. Cost:
/// O(n log n).
CornerNormals corner_normals(const Points& points, const std::vector<std::array<int, 3>>& triangles,
                             double crease_deg = 30);

}  // namespace batten
