// SPDX-License-Identifier: MPL-2.0
// Elementary geometry: cross product, bounding boxes, rotations, formatting of points, and angles.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {

/// z component of a × b: the signed area of the parallelogram, positive if b lies to the left of a.
inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Projects a point or direction onto the plane z = 0.
inline Vec2 drop_z(const Vec3& p) { return {p.x(), p.y()}; }

// Axis-aligned bounding boxes.

using Box2 = Eigen::AlignedBox2d;
using Box3 = Eigen::AlignedBox3d;

/// Smallest axis-aligned box that contains the points (2D or 3D). The box is empty if there are no
/// points.
template <class PointRange>
auto bounding_box(const PointRange& points) {
  using Point = std::decay_t<decltype(*points.begin())>;
  Eigen::AlignedBox<double, Point::RowsAtCompileTime> box;
  for (const Point& p : points) box.extend(p);
  return box;
}

// Rotations represented by rotation vectors.

/// Rotation vector r of the rotation by `angle` (radians) about `axis`: |r| is the full angle; r =
/// 0 is the identity.
///
/// The angle is not reduced: rotations by 350° and by -10° are the same rotation but have different
/// rotation vectors. Interpolated rotation vectors can thus represent several full turns. The
/// quaternion logarithms of [Masuda2006], eq. 6 and 7, are r/2. Rotation matrices: core/eigen.h.
inline Vec3 to_rotation_vector(const Vec3& axis, double angle) { return axis.normalized() * angle; }

/// The vector x, rotated by a rotation vector (unit axis times angle in radians). Cost: one sine,
/// one cosine and two cross products.
inline Vec3 rotated(const Vec3& rotation_vector, const Vec3& x) {
  const Vec3 q = rotation_vector / 2;
  const double half = q.norm();
  // sin(half)/half; below 1e-8 the next term of its series is smaller than the last digit.
  const double s = half > 1e-8 ? std::sin(half) / half : 1.0;
  const Vec3 v = s * q;
  const Vec3 t = v.cross(x);
  return x + 2 * (std::cos(half) * t + v.cross(t));
}

/// Product J(ω) x of the left Jacobian of the rotation group with a vector: a rotation vector ω that
/// changes at the rate x rotates with the angular velocity J(ω) x, so that
///
///     d/dt rotated(ω, v) = (J(ω) dω/dt) × rotated(ω, v),
///     J(ω) x = x + (1 - cos θ)/θ² ω × x + (θ - sin θ)/θ³ ω × (ω × x),   θ = |ω|
///
/// The transpose of J(ω) is J(-ω).
inline Vec3 left_jacobian(const Vec3& rotation_vector, const Vec3& x) {
  const double angle = rotation_vector.norm();
  const Vec3 once = rotation_vector.cross(x), twice = rotation_vector.cross(once);
  constexpr double small = 1e-3;  // the next terms of the series are below 1e-15
  const double square = angle * angle;
  const double half = std::sin(angle / 2);
  const double a = angle > small ? 2 * half * half / square : 0.5 - square / 24;
  const double b =
      angle > small ? (angle - std::sin(angle)) / (square * angle) : 1.0 / 6 - square / 120;
  return x + a * once + b * twice;
}

/// Rotation matrix of a rotation vector (unit axis times angle in radians).
inline Mat3 rotation_matrix(const Vec3& rotation_vector) {
  Mat3 R;
  for (int c = 0; c < 3; ++c) R.col(c) = rotated(rotation_vector, Vec3::Unit(c));
  return R;
}

// Text of points in messages, and angles between vectors.

/// Formats a point as "(x, y, z)". Components smaller than 1e-14 of the largest one are rounding
/// errors and are written as 0.
inline std::string format_point(const Vec3& p) {
  const double rounding = 1e-14 * p.cwiseAbs().maxCoeff();
  const auto word = [&](double x) { return format_number(std::abs(x) <= rounding ? 0.0 : x); };
  return "(" + word(p.x()) + ", " + word(p.y()) + ", " + word(p.z()) + ")";
}

/// Angle between two vectors of any length, in degrees in [0, 180]. Accurate to rounding even near
/// 0 and 180.
inline double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

}  // namespace batten
