// SPDX-License-Identifier: MPL-2.0
// Random motions for property tests of sequences.
#pragma once

#include <numbers>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

inline Mat3 random_rotation_matrix(Random& random, double largest = 3) {
  return rotation_matrix(to_rotation_vector(random.point(), largest * random()));
}

inline RigidMotion random_motion(Random& random) {
  return {random_rotation_matrix(random), random.point()};
}

/// Smooth points over time.
inline Points smooth_path(int frames, unsigned seed) {
  Random random(seed);
  const Vec3 a = random.point(), b = random.point(), c = random.point();
  Points p(frames, 3);
  for (int k = 0; k < frames; ++k)
    p.row(k) = 0.1 * k * a + std::sin(0.4 * k) * b + std::cos(0.15 * k) * c;
  return p;
}

/// Smooth rotations over time from the identity, over several full turns.
inline std::vector<Mat3> smooth_rotations(int frames, unsigned seed) {
  Random random(seed);
  const Vec3 a = random.point(), b = random.point();
  std::vector<Mat3> rotations;
  for (int k = 0; k < frames; ++k)
    rotations.push_back(rotation_matrix(to_rotation_vector(a, 0.3 * k)) *
                        rotation_matrix(to_rotation_vector(b, std::sin(0.2 * k))));
  return rotations;
}

inline double distance(const Points& a, const Points& b) {
  return a.rows() == b.rows() ? (a - b).rowwise().norm().maxCoeff() : 1e300;
}

inline double distance(const std::vector<Mat3>& a, const std::vector<Mat3>& b) {
  double largest = a.size() == b.size() ? 0 : 1e300;
  for (size_t k = 0; k < a.size() && k < b.size(); ++k)
    largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

inline double distance(const Trajectory& a, const Trajectory& b) {
  return std::max(distance(a.centres, b.centres), distance(a.rotations, b.rotations));
}

inline double distance(const RigidMotion& a, const RigidMotion& b) {
  return std::max((a.rotation - b.rotation).norm(), (a.translation - b.translation).norm());
}

}  // namespace batten_test
