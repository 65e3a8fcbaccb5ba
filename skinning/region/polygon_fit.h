// Fits the polygon of a domain: to given side lengths and angles, or for least distortion of a
// surface.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fem/surface.h"

namespace batten {

/// Thrown if no simple polygon fits the sides and corners, or only one without area. Another type
/// of domain may work.
class NoPolygonError : public InputError {
 public:
  using InputError::InputError;
};

/// Fits a simple counter-clockwise polygon to given side lengths and interior angles, by least
/// squares. Residuals are logarithms of lengths, angles and, weakly and up to 24 corners only,
/// distances between corners that are shorter than in space.
///
/// The angle φ of a corner has the weight max(1, |cot φ|), because the surface's Jacobian there is
/// sin φ / sin θ for the polygon's angle θ. So nearly straight and sharp corners keep their angle
/// and others change. A steep penalty keeps that Jacobian between ½ and 2, so that no corner
/// inverts (polygon_fit.cpp).
///
/// `lengths`: > 0. `angles`: radians in (0, 2π). `corners`: the corners in space, for the start and
/// for the distances. `normal`: the side from which the loop runs counter-clockwise. The polygon is
/// scaled so that sides keep their length on average. Throws NoPolygonError if no simple polygon is
/// found. Cost: O(steps · corners³), below a millisecond for 30 corners.
std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal);

/// Fits a polygon to given side lengths and interior angles (radians), with equal weights for all
/// angles. It starts from a circle and stays simple in every step. It is meant for sampled smooth
/// outlines of about a hundred corners at most. Throws InputError if the polygon on the circle is
/// not simple.
std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles);

/// True if sides of the polygon meet only at their common corners, and its signed area is positive.
/// O(n²).
bool is_simple_and_ccw(const std::vector<Vec2>& polygon);

// Improves the domain of an existing surface: the polygon of least distortion.

/// Distortion of a surface relative to its domain, up to a uniform scale. σ1 ≥ σ2: the singular
/// values of J = (x_u, x_v).
struct Distortion {
  double max_shear = 1;  ///< largest σ1/σ2
  double min_area = 1;   ///< smallest σ1 σ2 over its mean
  /// √ of the mean of (log σ1/s)² + (log σ2/s)² over the surface's area; log s is the mean of all
  /// log σ.
  double rms = 0;
};
/// Measures the distortion at the centroid of each triangle.
Distortion distortion(const Surface& surface);

/// Result of find_least_distorted_polygon().
struct LeastDistortedPolygon {
  /// Corresponding corners; same perimeter, rotated and translated to fit.
  std::vector<Vec2> polygon;
  Distortion before;
  /// Predicted distortion over the new polygon, if the surface does not change. If the surface is
  /// solved again over the new polygon, its distortion is close to this.
  Distortion expected;
};

/// Moves the corners of a domain to minimise the distortion of the surface over it, as far as
/// straight sides allow. It minimises the logarithmic strain about its mean scale
///
///   ∬ |½ log(Jᵀ J / s²)|² dA  =  ∬ (log σ1/s)² + (log σ2/s)² dA
///
/// over the positions of the corners, by Levenberg-Marquardt. The interior follows by mean value
/// coordinates [Floater2003] of the given polygon, linear on the sides and on each triangle of the
/// mesh. Stretching and compression count equally. A step that inverts the domain is rejected, so
/// that the polygon stays simple and counter-clockwise. For a singular surface the polygon is
/// returned unchanged.
///
/// `polygon`: the corners of the surface's domain, counter-clockwise. Throws InputError for fewer
/// than three corners, or a mesh that is not inside the polygon. Cost: O(steps · corners² ·
/// triangles), a few milliseconds for few corners.
LeastDistortedPolygon find_least_distorted_polygon(const Surface& surface,
                                                   const std::vector<Vec2>& polygon);

}  // namespace batten
