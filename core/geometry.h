// Small geometry of the (u, v) plane.
#pragma once

#include <type_traits>
#include <cmath>
#include <numbers>
#include <string>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {

/// Area of the parallelogram of a and b, positive when b lies to the left of a.
inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A point or direction of a curve in the plane z = 0.
inline Vec2 drop_z(const Vec3& p) { return {p.x(), p.y()}; }


// Boxes along the axes.

using Box2 = Eigen::AlignedBox2d;
using Box3 = Eigen::AlignedBox3d;

/// The smallest box around points of the plane or of space; without points the empty one.
template <class PointRange>
auto bounding_box(const PointRange& points) {
  using Point = std::decay_t<decltype(*points.begin())>;
  Eigen::AlignedBox<double, Point::RowsAtCompileTime> box;
  for (const Point& p : points) box.extend(p);
  return box;
}


// Rotations as logarithms of unit quaternions.

/// The logarithm q of a unit quaternion stands for the turn by 2|q| about q/|q|; q = 0 is no turn.
/// It is not reduced: a turn by 350° and one by -10° are different logarithms of one rotation, so
/// that a field of logarithms winds as far as it was asked to. Source: Masuda et al. 2006, eq.
/// 6, 7.
inline Vec3 to_rotation_vector(const Vec3& axis, double angle) {
  return axis.normalized() * angle;
}
/// The shortest logarithm of a rotation matrix.
inline Vec3 to_rotation_vector(const Mat3& R) {
  const Eigen::AngleAxisd rotation(R);
  return to_rotation_vector(rotation.axis(), rotation.angle());
}

/// The vector R(q) x: one sine, one cosine, two cross products.
inline Vec3 rotated(const Vec3& rotation_vector, const Vec3& x) {
  const Vec3 q = rotation_vector / 2;
  const double half = q.norm();
  // sin(h)/h; below 1e-8 the next term is under the last digit.
  const double s = half > 1e-8 ? std::sin(half) / half : 1.0;
  const Vec3 v = s * q;
  const Vec3 t = v.cross(x);
  return x + 2 * (std::cos(half) * t + v.cross(t));
}

/// The matrix R(q).
inline Mat3 rotation_matrix(const Vec3& rotation_vector) {
  Mat3 R;
  for (int c = 0; c < 3; ++c) R.col(c) = rotated(rotation_vector, Vec3::Unit(c));
  return R;
}


// Points in messages, and angles, said the same way everywhere.

/// The text "(x, y, z)" of a point; what is only rounding beside the largest coordinate is 0.
inline std::string format_point(const Vec3& p) {
  const double rounding = 1e-14 * p.cwiseAbs().maxCoeff();
  const auto word = [&](double x) { return format_number(std::abs(x) <= rounding ? 0.0 : x); };
  return "(" + word(p.x()) + ", " + word(p.y()) + ", " + word(p.z()) + ")";
}

/// Angle between two vectors of any length, degrees in [0, 180]; exact to rounding near 0 and 180.
inline double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

}  // namespace batten
