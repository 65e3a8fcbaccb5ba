// A triangle that bulges as its corners' normals say.
#pragma once

#include <array>

#include "batten/core/eigen.h"

namespace batten {

/// The cubic Bézier triangle that begins at each corner in the corner's tangent plane, and whose inner
/// control point gives back quadratics. A surface's points and unit normals at the corners of triangles of
/// size h are met to O(h³), mostly O(h⁴); flat triangles to O(h²). With three equal normals across its plane
/// it is the flat triangle. Source: Vlachos et al. 2001, "Curved PN triangles", section 3.1.
class PnTriangle {
 public:
  using Corners = std::array<Vec3, 3>;
  PnTriangle(const Corners& points, const Corners& normals);

  /// Position and derivatives by the second and third barycentric coordinate.
  struct Jet {
    Vec3 x, u, v, uu, uv, vv;
  };
  Jet jet(const Vec3& weights) const;
  Vec3 at(const Vec3& weights) const { return jet(weights).x; }

 private:
  // Control points by the corners that they are nearest to: 0, 1, 2, 001, 011, 112, 122, 220, 200, 012.
  std::array<Vec3, 10> b_;
};

}  // namespace batten
