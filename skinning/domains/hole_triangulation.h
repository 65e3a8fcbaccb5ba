// SPDX-License-Identifier: MPL-2.0
// Triangulations of a closed 3D polyline without interior points: hole filling [Liepa2003], and a
// nearly developable triangulation.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A triangulation of a closed polyline whose only vertices are the points of the polyline. The
/// triangles have the orientation of the polyline.
struct HoleTriangulation {
  /// Corners of each triangle, as indices into the points of the closed polyline.
  std::vector<std::array<int, 3>> triangles;
  double area = 0;  ///< total area of the triangles, model units²
  /// Sum of the area vectors of the triangles, model units²: the area vector of the polyline.
  Vec3 area_vector = Vec3::Zero();
  /// Largest angle between the normals of adjacent triangles, degrees.
  double max_dihedral_deg = 0;
};

/// Computes the triangulation of a closed polyline (first point not repeated) that minimises the
/// largest dihedral angle and, among triangulations with the same angle, the area [Liepa2003]. The
/// function calls triangulate_hole_polyline() of CGAL. Returns nullopt if there is no
/// triangulation, or in a build without CGAL.
///
/// `loop`: 3 to 400 points. Cost: O(n³) for n points, usually O(n log n). Throws InputError for
/// fewer or more points, and for coordinates that are not finite.
std::optional<HoleTriangulation> triangulate_hole(const std::vector<Vec3>& loop);

/// Computes a triangulation of a closed polyline with small bending and small area. It is a
/// discrete developable surface, because all its vertices lie on the loop. By dynamic programming
/// over sub-polygons it minimises
///
///         Σ A    +    0.03 d²      Σ      2 sin²(θ/2) |e|² / min(A₁, A₂)   ≈   ∬ 1 + 0.03 d² κ² dA
///     triangles               inner edges
///
/// for triangles of area A and inner edges e between two triangles of areas A₁ and A₂, whose
/// normals differ by the angle θ; d is the diagonal of the bounding box of the points, κ the
/// curvature of the surface. With this energy, the triangulation of a strip around a cylinder
/// follows the cylinder; triangulate_hole() does not achieve this. The minimum of A₁ and A₂ is
/// essential: with the sum A₁ + A₂, the energy of an edge between a large and a small triangle
/// would be too small, and a cylindrical strip of 350 degrees would be closed by two discs.
///
/// Returns nullopt if all points lie on one straight line. Cost: O(n³) for n points [Klincsek1980],
/// 10 ms for 150 points. CGAL is not required. `loop` and exceptions: see triangulate_hole().
std::optional<HoleTriangulation> developable_triangulation(const std::vector<Vec3>& loop);

/// Normal and interior angle of a triangulation at one point of the closed polyline that it fills.
/// `normal`: sum of the area vectors of the triangles at the point. `angle`: sum of the angles of
/// these triangles at the point, radians.
struct TriangulationCorner {
  Vec3 normal = Vec3::Zero();
  double angle = 0;
};
/// Computes the normal and the interior angle of a triangulation at each point of `loop`.
std::vector<TriangulationCorner> triangulation_corners(const std::vector<Vec3>& loop,
                                                       const HoleTriangulation& triangulation);

/// Tests whether a closed polyline turns left at a corner, seen from the tip of the normal of its
/// triangulation there (`corner`). `before`, `after`: directions of the polyline before and after
/// the corner. If the direction changes by at most 20 degrees, TriangulationCorner::normal decides;
/// otherwise the corner turns left if TriangulationCorner::angle is below π.
bool turns_left(const Vec3& before, const Vec3& after, const TriangulationCorner& corner);

}  // namespace batten
