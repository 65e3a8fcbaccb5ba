// Small geometry of the (u, v) plane.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Area of the parallelogram of a and b, positive when b lies to the left of a.
inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A point or direction of a curve in the plane z = 0.
inline Vec2 drop_z(const Vec3& p) { return {p.x(), p.y()}; }

}  // namespace batten
