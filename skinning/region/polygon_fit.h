// SPDX-License-Identifier: MPL-2.0
// Computes polygonal domains: from given side lengths and angles, or for the least distortion of a
// given surface.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fem/surface.h"

namespace batten {

/// Thrown if no simple polygon fits the side lengths and angles, or if the fitted polygon has no
/// area. Another type of domain (SkinOptions::Domain) may work.
class NoPolygonError : public InputError {
 public:
  using InputError::InputError;
};

/// Fits a simple counter-clockwise polygon to given side lengths and interior angles, by least
/// squares. The residuals are the relative errors (logarithms) of the lengths, and the errors of
/// the angles. For up to 24 corners, residuals with a small weight are added if corners are closer
/// to each other in the polygon than in space.
///
/// The error of the angle at a corner, φ between the curves and θ in the polygon, has the weight
/// max(1, |cot φ|), because the Jacobian of the surface there is sin φ / sin θ. Nearly straight
/// corners and sharp corners therefore keep their angles, and the angles of other corners change. A
/// steep penalty keeps this Jacobian between ½ and 2, so that no corner inverts (polygon_fit.cpp).
///
/// `lengths`: > 0. `angles`: radians in (0, 2π). `corners`: positions of the corners in space, for
/// the initial polygon and for the distances between corners. `normal`: direction from whose tip
/// the loop is seen counter-clockwise. The polygon is scaled so that its sides have the given
/// lengths on average. Throws NoPolygonError if no simple polygon is found. Cost: O(steps ·
/// corners³), below a millisecond for 30 corners.
std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal);

/// Fits a polygon to given side lengths and interior angles (radians), with equal weights for all
/// angles. The iteration starts with a polygon inscribed in a circle, and the polygon stays simple
/// in every step. Use this function for smooth outlines sampled at up to about a hundred points.
/// Throws InputError if the inscribed polygon is not simple.
std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles);

/// True if the sides of the polygon meet only at their common corners, and if the signed area is
/// positive. O(n²) for n corners.
bool is_simple_and_ccw(const std::vector<Vec2>& polygon);

// Improves the domain of an existing surface: the polygon of least distortion.

/// Distortion of a surface relative to its domain, up to a uniform scale. σ1 ≥ σ2 are the singular
/// values of J = (x_u, x_v).
struct Distortion {
  double max_shear = 1;  ///< largest ratio σ1/σ2 of the singular values of (x_u, x_v)
  double min_area = 1;   ///< smallest area factor |x_u × x_v|, divided by its mean
  /// Root mean square strain: √ of the mean of (log σ1/s)² + (log σ2/s)² over the area of the
  /// surface, where σ1 and σ2 are the singular values of (x_u, x_v), and log s is the mean of all
  /// log σ.
  double rms = 0;
};
/// Measures the distortion of a surface relative to its domain, at the centroid of each triangle.
Distortion distortion(const Surface& surface);

/// Result of find_least_distorted_polygon().
struct LeastDistortedPolygon {
  /// Corners of the new polygon, in the order of the corners of the initial polygon. The perimeter
  /// is unchanged, and the new polygon is rotated and translated to fit the initial one best.
  std::vector<Vec2> polygon;
  Distortion before;
  /// Distortion of the surface relative to the new polygon if the surface keeps its shape. A
  /// surface that is solved again over the new polygon has nearly this distortion.
  Distortion expected;
};

/// Moves the corners of a polygonal domain to minimise the distortion of a surface over this
/// domain. It minimises the logarithmic strain relative to the mean scale s,
///
///   ∬ |½ log(Jᵀ J / s²)|² dA  =  ∬ (log σ1/s)² + (log σ2/s)² dA
///
/// over the positions of the corners, by Levenberg-Marquardt. σ1 and σ2 are the singular values of
/// J = (x_u, x_v). The interior of the domain follows the corners by mean value coordinates
/// [Floater2003] of the given polygon, interpolated linearly on the sides and on each triangle of
/// the mesh. Stretching and compression have equal weights. A step that inverts the domain is
/// rejected, so that the polygon stays simple and counter-clockwise. For a singular surface the
/// polygon is returned unchanged.
///
/// `polygon`: the corners of the domain of `surface`, counter-clockwise. Throws InputError for
/// fewer than three corners, or a mesh that is not inside the polygon. Cost: O(steps · corners² ·
/// triangles), a few milliseconds for few corners.
LeastDistortedPolygon find_least_distorted_polygon(const Surface& surface,
                                                   const std::vector<Vec2>& polygon);

}  // namespace batten
