// Fills a closed polyline with triangles: as plain hole filling (CGAL), or as a developable
// surface.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// The triangles have the points of the loop as corners and no others; they run counter-clockwise
/// along it.
struct HoleTriangulation {
  std::vector<std::array<int, 3>> triangles;
  double area = 0;                  ///< of all triangles, model units²
  Vec3 area_vector = Vec3::Zero();  ///< ½ Σ of cross products: its direction is the loop's normal
  double max_dihedral_deg = 0;      ///< largest angle between normals of neighbours
};

/// Returns the triangulation of a closed polyline (first point not repeated) whose largest dihedral
/// angle is least, and of several such ones that of least area (Liepa 2003; CGAL's
/// triangulate_hole_polyline). Nothing when there is none, or in a build without CGAL. At most 400
/// points. O(n³), mostly O(n log n).
/// Throws InputError: fewer than three points, numbers that are not finite.
std::optional<HoleTriangulation> triangulate_hole(const std::vector<Vec3>& loop);

/// Returns a triangulation of a closed polyline that is little bent and small. It is a developable
/// surface in triangles, because all their corners lie on the loop. It makes least, among sums of
/// best parts,
///
///         Σ A    +    0.03 d²      Σ      2 sin²(θ/2) |e|² / min(A₁, A₂)   ≈   ∬ 1 + 0.03 d² κ² dA
///     triangles               inner edges
///
/// for triangles of area A, edges e where normals turn by θ, d: the diagonal of the box of the
/// points. With this, unlike with the least largest angle, a strip around a cylinder stays a strip;
/// with the sum of both areas a large triangle beside a small one would make an edge between them
/// cheap, and a strip of 350 degrees two discs.
/// Nothing when all points lie on one line. Dynamic programming over pairs of points (Klincsek
/// 1980), O(n³): 10 ms for 150 points, no library. Throws as triangulate_hole().
std::optional<HoleTriangulation> developable_triangulation(const std::vector<Vec3>& loop);

/// The triangles around one point of the loop: the sum of their area vectors, which says to which
/// side the filling faces there, and the sum of their angles, which is the interior angle
/// (radians).
struct TriangulationCorner {
  Vec3 normal = Vec3::Zero();
  double angle = 0;
};
/// Returns these for each point of the loop.
std::vector<TriangulationCorner> triangulation_corners(const std::vector<Vec3>& loop,
                                                       const HoleTriangulation& triangulation);

/// Returns whether a loop with these directions before and after a corner turns to the left there,
/// seen on the filling: small turns are judged by its normal, others by its angle.
bool turns_left(const Vec3& before, const Vec3& after, const TriangulationCorner& corner);

}  // namespace batten
