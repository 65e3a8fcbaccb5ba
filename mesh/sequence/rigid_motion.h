// Motions that keep every distance.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// p → turn p + shift.
struct RigidMotion {
  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return turn * p + shift; }
  /// First the other one, then this.
  RigidMotion operator*(const RigidMotion& first) const {
    return {turn * first.turn, turn * first.shift + shift};
  }
  RigidMotion inverse() const { return {turn.transpose(), -(turn.transpose() * shift)}; }
  /// Turns about `from` and takes it to `to`.
  static RigidMotion about(const Vec3& from, const Mat3& turn, const Vec3& to) {
    return {turn, to - turn * from};
  }
};

/// All points moved.
inline Points moved(const Points& points, const RigidMotion& motion) {
  return (points * motion.turn.transpose()).rowwise() + motion.shift.transpose();
}

}  // namespace batten
