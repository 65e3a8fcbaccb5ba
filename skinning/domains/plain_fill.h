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
  double area = 0;                  ///< of all triangles, model units²
  Vec3 area_vector = Vec3::Zero();  ///< ½ Σ of cross products: its direction is the loop's normal
  double worst_fold_deg = 0;        ///< largest angle between normals of neighbours
};

/// The triangulation of a closed polyline (first point not repeated) with the least worst dihedral
/// angle, then least area (Liepa 2003; CGAL's triangulate_hole_polyline). None when there is none,
/// or in a build without CGAL. At most 400 points. O(n³), O(n log n) mostly.
/// Throws InputError: fewer than three points, numbers that are not finite.
std::optional<PlainFill> plain_fill(const std::vector<Vec3>& loop);

/// The triangulation of a closed polyline that is little bent, then small: a developable surface in
/// triangles, as all corners lie on the loop. Least, among sums of best parts, of
///
///     Σ A  +  0.03 d² Σ 4 sin²(θ/2) |e|² / (A₁ + A₂)   ≈   ∬ 1 + 0.03 d² κ² dA
///              triangles         inner edges
///
/// for triangles of area A, edges e where normals turn by θ, d: the diagonal of the box of the
/// points. Other than the least worst angle, this keeps a strip around a cylinder a strip. None
/// when all points lie on one line. Dynamic programming over pairs of points (Klincsek 1980),
/// O(n³): 10 ms for 150 points, no library. Throws as plain_fill().
std::optional<PlainFill> developable_fill(const std::vector<Vec3>& loop);

/// At each point of the loop, of the triangles around it: the sum of their area vectors (to which
/// side the filling faces there) and of their angles (interior angle, radians).
struct FillCorner {
  Vec3 normal = Vec3::Zero();
  double angle = 0;
};
std::vector<FillCorner> fill_corners(const std::vector<Vec3>& loop, const PlainFill& fill);

/// Whether a loop with these directions before and after a corner turns to the left there, as the
/// filling has it: small turns by its normal, others by its angle.
bool turns_left(const Vec3& before, const Vec3& after, const FillCorner& corner);

}  // namespace batten
