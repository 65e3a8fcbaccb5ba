// SPDX-License-Identifier: MPL-2.0
// Rigid motions, and trajectories of groups of vertices through the frames of a sequence.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Rigid motion p → rotation · p + translation, with det(rotation) = +1.
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

/// Composition of two rigid motions: p → a(b(p)).
inline RigidMotion operator*(const RigidMotion& a, const RigidMotion& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

/// Applies a rigid motion to all points (n×3). O(n).
inline Points moved(const RigidMotion& motion, const Points& points) {
  Points result = points * motion.rotation.transpose();
  result.rowwise() += motion.translation.transpose();
  return result;
}

/// Centroid of the given vertices of a frame p (n×3); zero if `vertices` is empty. The sum is
/// computed relative to the first vertex, since sums far from the origin lose digits.
Vec3 centroid(const Points& p, const std::vector<int>& vertices);

/// Trajectory of a group of vertices: its centroid and rotation in each of F frames.
struct Trajectory {
  Points centres;  ///< centroid in each frame, F×3
  /// Rotation from the first frame to each of the F frames; the first one is the identity.
  std::vector<Mat3> rotations;

  int frame_count() const { return static_cast<int>(centres.rows()); }
};

/// Computes the trajectory of a group of vertices: centroids, and least-squares rotations from the
/// first frame (fit_similarity() with scale 1). For collinear vertices, the rotation is the
/// smallest one that fits; for a single vertex, it is the identity. Throws InputError if there are
/// no vertices or a vertex is out of range. O(frames · vertices).
Trajectory trajectory_of(const std::vector<Points>& frames, const std::vector<int>& vertices);

/// Root trajectory of a sequence: the trajectory of the centroid of all nodes, with identity
/// rotations. O(frames · nodes).
Trajectory root_trajectory(const std::vector<Points>& frames);

/// Applies one rigid motion M_k per frame k to a trajectory with centres c_k and rotations R_k. The
/// new centres are M_k(c_k), the new rotations M_k.rotation · R_k. Throws InputError if the numbers
/// of motions and frames differ.
Trajectory moved(const std::vector<RigidMotion>& motions, const Trajectory& trajectory);

/// Rigid motions that move trajectory `from` to trajectory `to`, one per frame k. Each motion
/// rotates by R'_k R_kᵀ and moves the centre c_k to c'_k, where c_k, R_k belong to `from` and c'_k,
/// R'_k to `to`. Throws InputError if the numbers of frames differ.
std::vector<RigidMotion> motions_between(const Trajectory& from, const Trajectory& to);

}  // namespace batten
