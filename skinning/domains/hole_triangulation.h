// Triangulations of a closed 3D polyline without interior points: hole filling [Liepa2003], and a
// nearly developable triangulation.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A triangulation whose vertices are the points of the loop and no others. Triangles are
/// counter-clockwise in the direction of the loop.
struct HoleTriangulation {
  /// Indices into the loop.
  std::vector<std::array<int, 3>> triangles;
  double area = 0;  ///< of all triangles, model units²
  /// ½ Σ of the triangles' cross products: along the loop's normal.
  Vec3 area_vector = Vec3::Zero();
  double max_dihedral_deg = 0;  ///< largest angle between normals of adjacent triangles
};

/// Computes the triangulation of a closed polyline (first point not repeated) that minimises the
/// largest dihedral angle and, among equals, the area [Liepa2003]. It calls CGAL's
/// triangulate_hole_polyline(). Returns nullopt if there is none, or in a build without CGAL.
///
/// `loop`: 3 to 400 points. Cost: O(n³), mostly O(n log n). Throws InputError for fewer or more
/// points and for non-finite coordinates.
std::optional<HoleTriangulation> triangulate_hole(const std::vector<Vec3>& loop);

/// Computes a triangulation of a closed polyline with small bending and small area. It is a
/// discrete developable surface, because all its vertices lie on the loop. By dynamic programming
/// over sub-polygons it minimises
///
///         Σ A    +    0.03 d²      Σ      2 sin²(θ/2) |e|² / min(A₁, A₂)   ≈   ∬ 1 + 0.03 d² κ² dA
///     triangles               inner edges
///
/// for triangles of area A and inner edges e, whose adjacent normals differ by the angle θ; d is
/// the diagonal of the bounding box of the points. With this energy a strip around a cylinder stays
/// a strip, which it does not if the largest dihedral angle is minimised. The minimum of the two
/// areas is essential: with their sum, an edge between a large and a small triangle would be cheap,
/// and a strip of 350 degrees would become two discs.
///
/// Returns nullopt if all points lie on one straight line. O(n³) [Klincsek1980]: 10 ms for 150
/// points; needs no library. Throws as triangulate_hole().
std::optional<HoleTriangulation> developable_triangulation(const std::vector<Vec3>& loop);

/// The triangles around one point of the loop. `normal`: sum of their area vectors, the side to
/// which the triangulation faces there. `angle`: sum of their angles, which is the interior angle
/// (radians).
struct TriangulationCorner {
  Vec3 normal = Vec3::Zero();
  double angle = 0;
};
/// Computes normal and interior angle at each point of the loop.
std::vector<TriangulationCorner> triangulation_corners(const std::vector<Vec3>& loop,
                                                       const HoleTriangulation& triangulation);

/// Tests whether a loop turns left at a corner, seen on the triangulation. `before`, `after`:
/// directions of the loop there. Changes of direction up to 20 degrees are decided by the corner's
/// normal, others by its interior angle.
bool turns_left(const Vec3& before, const Vec3& after, const TriangulationCorner& corner);

}  // namespace batten
