// Finds polygons with wished sides and angles.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fem/surface.h"

namespace batten {

/// Thrown when no polygon has such sides and corners, or only one without area; another domain may
/// do.
class NoPolygonError : public InputError {
 public:
  using InputError::InputError;
};

/// Returns a simple counter-clockwise polygon whose side lengths and interior angles come as near
/// to the given ones as they can together, by least squares over log lengths, angles and (weakly,
/// up to 24 corners) distances between corners that are shorter than in space. The angle φ of a
/// corner has the weight max(1, |cot φ|), because the surface's Jacobian there is sin φ / sin θ for
/// the polygon's angle θ: corners of little turn keep their angle, others give way. A steep penalty
/// keeps that Jacobian between ½ and 2, so that no corner turns the other way (polygon_fit.cpp).
/// `corners`: the corners in space, for the start and those distances; `normal`: the side from
/// which the loop runs counter-clockwise. The scale is such that sides keep their length on
/// average. Throws NoPolygonError when no simple polygon is found. O(steps · corners³), below a
/// millisecond for 30.
std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal);

/// Returns a polygon whose sides and interior angles come as near to the given ones as they can,
/// all angles with one weight. It begins with a circle and stays simple on the way. It is for
/// sampled smooth outlines, of about a hundred corners at most. Throws as fit_polygon().
std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles);

/// Returns whether sides of the polygon meet only at their common corners, and its area is
/// positive. O(n²).
bool is_simple_and_ccw(const std::vector<Vec2>& polygon);


// Finds a better domain for a surface that is there already: the polygon that distorts it least.

/// How far a surface is from its domain as a flat sheet, whatever the scale. σ1 ≥ σ2: the singular
/// values of J = (x_u, x_v).
struct Distortion {
  double max_shear = 1;  ///< largest σ1/σ2
  double min_area = 1;   ///< least σ1 σ2 over its mean
  /// √ mean of (log σ1/s)² + (log σ2/s)² over the surface's area; log s is the mean of all log σ.
  double rms = 0;
};
/// Measures it at the centroid of each triangle.
Distortion distortion(const Surface& surface);

/// The polygon that was found.
struct LeastDistortedPolygon {
  std::vector<Vec2> polygon;  ///< corner for corner; of the same perimeter, turned and moved to fit
  Distortion before;
  /// Distortion of the same surface carried along to the new polygon; a surface that is made anew
  /// there comes near to it.
  Distortion expected;
};

/// Moves the corners of a domain so that the surface over it is as little distorted as straight
/// sides allow: least squares of the logarithmic strain about its mean scale
///
///   ∬ |½ log(Jᵀ J / s²)|² dA  =  ∬ (log σ1/s)² + (log σ2/s)² dA
///
/// over the corners' positions. The inside follows by mean value coordinates of the given polygon
/// (Floater 2003), linear on the sides and on each triangle of the mesh. Stretching counts as much
/// as squeezing; a step that folds the domain is not taken, so that the polygon stays simple and
/// counter-clockwise. A singular surface leaves it as it is.
///
/// `polygon`: the corners of the surface's domain, counter-clockwise. Throws InputError: fewer than
/// three corners, a mesh that is not inside of the polygon.
/// O(steps · corners² · triangles), a few milliseconds for few corners.
LeastDistortedPolygon find_least_distorted_polygon(const Surface& surface,
                                                   const std::vector<Vec2>& polygon);

}  // namespace batten
