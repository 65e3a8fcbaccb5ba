// Rigid motions, and trajectories of groups of vertices through the frames of a sequence.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Rigid motion p → rotation · p + translation, det rotation = +1.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator()(const Vec3& p) const { return rotation * p + translation; }
  /// The inverse motion p → rotationᵀ (p - translation).
  RigidMotion inverse() const {
    return {rotation.transpose(), -(rotation.transpose() * translation)};
  }
  /// The motion that rotates by `rotation` about the point `about` and moves this point to `to`.
  static RigidMotion about(const Vec3& about, const Mat3& rotation, const Vec3& to) {
    return {rotation, to - rotation * about};
  }
};

/// Composition: first `b`, then `a`.
inline RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

/// Applies a motion to all points (n×3). O(points).
inline Points moved(const RigidMotion& motion, const Points& points) {
  Points result = points * motion.rotation.transpose();
  result.rowwise() += motion.translation.transpose();
  return result;
}

/// Centroid of some vertices of a frame; zero if there are none. Summed relative to the first
/// vertex, since sums far from the origin lose digits.
Vec3 centroid(const Points& p, const std::vector<int>& vertices);

/// Centroid and rotation of a group of vertices in each of F frames.
struct Trajectory {
  Points centres;  ///< F×3
  /// F rotations, relative to the first frame, where it is the identity.
  std::vector<Mat3> rotations;

  int frame_count() const { return static_cast<int>(centres.rows()); }
};

/// Computes the trajectory of a group of vertices: centroids, and best rotations from the first
/// frame (least squares, fit_similarity() with scale 1). Collinear vertices get the smallest
/// rotation that fits, a single vertex the identity. Throws InputError: no vertices, a vertex out
/// of range. O(frames · vertices).
Trajectory trajectory_of(const std::vector<Points>& frames, const std::vector<int>& vertices);

/// Trajectory of the mean of all nodes, without rotations: the root of a sequence. O(frames ·
/// nodes).
Trajectory root_trajectory(const std::vector<Points>& frames);

/// Applies one motion M_k per frame to a trajectory: centres M_k c_k, rotations M_k R_k. Throws
/// InputError if the numbers of motions and frames differ.
Trajectory moved(const std::vector<RigidMotion>& motions, const Trajectory& trajectory);

/// Rigid motion of each frame that takes trajectory `from` to trajectory `to`: rotation R'_k R_kᵀ
/// about c_k, which moves to c'_k. Throws InputError if the numbers of frames differ.
std::vector<RigidMotion> motions_between(const Trajectory& from, const Trajectory& to);

}  // namespace batten
