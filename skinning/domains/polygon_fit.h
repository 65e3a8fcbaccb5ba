// Polygons with wished sides and angles.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {

/// No polygon has such sides and corners, or one without room inside only; another domain may do.
class NoPolygon : public InputError {
 public:
  using InputError::InputError;
};

/// A simple counter-clockwise polygon with the given side lengths and interior angles as nearly as
/// they can be had together, by least squares over log lengths, angles and (weakly, up to 24
/// corners) distances between corners that are shorter than in space. Angles φ weigh |cot φ| where
/// that is above 1, because the surface's Jacobian at a corner is sin φ / sin θ of the polygon's
/// angle θ: nearly straight and sharp corners keep theirs, wide ones give way. Beyond half and
/// twice that Jacobian a wall rises, so that a corner does not turn the other way
/// (polygon_fit.cpp). `corners`: the corners in space, for the start and those distances; `normal`:
/// the side from which the loop runs counter-clockwise. Scale: sides keep their length on average.
/// Throws NoPolygon when no simple polygon is found. O(steps · corners³), below a millisecond
/// for 30.
std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal);

/// A polygon whose sides and interior angles are as nearly as they can be those given, all angles
/// alike, begun with a circle and simple throughout. For sampled smooth outlines, at most about a
/// hundred corners. Throws InputError like fit_polygon().
std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles);

/// Whether no sides of the polygon meet but neighbours at their corner, and its area is positive.
/// O(n²).
bool simple_and_ccw(const std::vector<Vec2>& polygon);

}  // namespace batten
