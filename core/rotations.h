// Rotations as logarithms of unit quaternions.
#pragma once

#include <cmath>

#include "batten/core/eigen.h"

namespace batten {

/// The logarithm q of a unit quaternion stands for the turn by 2|q| about q/|q|; q = 0 is no turn.
/// It is not reduced: a turn by 350° and one by -10° are different logarithms of one rotation, so
/// that a field of logarithms winds as far as it was asked to. Source: Masuda et al. 2006, eq.
/// 6, 7.
inline Vec3 to_rotation_vector(const Vec3& axis, double angle) {
  return axis.normalized() * (angle / 2);
}
/// The shortest logarithm of a rotation matrix.
inline Vec3 to_rotation_vector(const Mat3& R) {
  const Eigen::AngleAxisd turn(R);
  return to_rotation_vector(turn.axis(), turn.angle());
}

/// The vector R(q) x: one sine, one cosine, two cross products.
inline Vec3 rotated(const Vec3& q, const Vec3& x) {
  const double half = q.norm();
  // sin(h)/h; below 1e-8 the next term is under the last digit.
  const double s = half > 1e-8 ? std::sin(half) / half : 1.0;
  const Vec3 v = s * q;
  const Vec3 t = v.cross(x);
  return x + 2 * (std::cos(half) * t + v.cross(t));
}

/// The matrix R(q).
inline Mat3 rotation_matrix(const Vec3& q) {
  Mat3 R;
  for (int c = 0; c < 3; ++c) R.col(c) = rotated(q, Vec3::Unit(c));
  return R;
}

}  // namespace batten
