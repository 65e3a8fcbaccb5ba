// Plain hole filling: triangles over a closed polyline, by a library.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Triangles over the points of the loop, counter-clockwise along it, no others.
struct PlainFill {
  std::vector<std::array<int, 3>> triangles;
  double area = 0;           ///< of all triangles, model units²
  Vec3 area_vector = Vec3::Zero();  ///< ½ Σ of cross products: its direction is the loop's normal
  double worst_fold_deg = 0;  ///< largest angle between normals of neighbours
};

/// The triangulation of a closed polyline (first point not repeated) with the least worst dihedral
/// angle, then least area (Liepa 2003; CGAL's triangulate_hole_polyline). None when there is none,
/// or in a build without CGAL. At most 400 points. O(n³), O(n log n) mostly.
/// Throws InputError: fewer than three points, numbers that are not finite.
std::optional<PlainFill> plain_fill(const std::vector<Vec3>& loop);

}  // namespace batten
