// Rigid motions, and how a group of vertices moves through the frames of a sequence.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// p → turn · p + shift, det turn = +1.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return rotation * p + translation; }
  /// p → turnᵀ (p - shift).
  RigidMotion inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation)};
  }
  /// Turns by `rotation` about `about`, which goes to `to`.
  static RigidMotion about(const Vec3& about, const Mat3& rotation, const Vec3& to) {
    return {rotation, to - rotation * about};
  }
};

/// First `b`, then `a`.
inline RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

/// All points moved. O(points).
inline Points moved(const RigidMotion& motion, const Points& points) {
  Points result = points * motion.rotation.transpose();
  result.rowwise() += motion.translation.transpose();
  return result;
}

/// The mean of some vertices of a frame; zero of none. Summed relative to the first of them: far from the
/// origin sums lose digits.
Vec3 centroid(const Points& p, const std::vector<int>& vertices);

/// Where a group of vertices is in each of F frames: its centroid, and its rotation.
struct Trajectory {
  Points centres;               ///< F×3
  std::vector<Mat3> rotations;  ///< F; from the first frame, where it is the identity

  int frame_count() const { return static_cast<int>(centres.rows()); }
};

/// Centroids of some vertices and their best rotations (least squares, `fit_similarity` with scale
/// 1) from the first frame. Vertices on one line turn by the smallest rotation that fits, one
/// vertex not at all. Throws InputError: no vertices, a vertex that a frame does not have. O(frames
/// · vertices).
Trajectory trajectory_of(const std::vector<Points>& frames, const std::vector<int>& vertices);

/// Trajectories of a motion M_k of each frame: centres M_k c_k, turns M_k R_k. Throws InputError on
/// another number of motions than frames.
Trajectory moved(const std::vector<RigidMotion>& motions, const Trajectory& trajectory);

/// Of each frame the rigid motion that takes a group from where it was to where it shall be:
/// R = R'_k R_kᵀ about c_k, which goes to c'_k. Throws InputError on different numbers of frames.
std::vector<RigidMotion> motions_between(const Trajectory& from, const Trajectory& to);

}  // namespace batten
