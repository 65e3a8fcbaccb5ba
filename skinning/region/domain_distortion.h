// Finds a better domain for a surface that is there already: the polygon that distorts it least.
#pragma once

#include <vector>

#include "batten/fem/surface.h"

namespace batten {

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
