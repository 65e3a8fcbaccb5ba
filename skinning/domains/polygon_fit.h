// Finds polygons with wished sides and angles.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

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

}  // namespace batten
