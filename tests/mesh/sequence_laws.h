// What the laws of sequences are tested on.
#pragma once

#include <numbers>
#include <vector>

#include "batten/core/rotations.h"
#include "batten/mesh/sequence/rigid_motion.h"
#include "batten/tests/sampling.h"

namespace batten_test {

inline Mat3 random_turn(Random& random, double largest = 3) {
  return rotation_matrix(rotation_log(random.point(), largest * random()));
}

inline RigidMotion random_motion(Random& random) { return {random_turn(random), random.point()}; }

/// Smooth points over time.
inline Points wandering(int frames, unsigned seed) {
  Random random(seed);
  const Vec3 a = random.point(), b = random.point(), c = random.point();
  Points p(frames, 3);
  for (int k = 0; k < frames; ++k)
    p.row(k) = 0.1 * k * a + std::sin(0.4 * k) * b + std::cos(0.15 * k) * c;
  return p;
}

/// Smooth rotations over time from the identity, of several turns.
inline std::vector<Mat3> winding(int frames, unsigned seed) {
  Random random(seed);
  const Vec3 a = random.point(), b = random.point();
  std::vector<Mat3> turns;
  for (int k = 0; k < frames; ++k)
    turns.push_back(rotation_matrix(rotation_log(a, 0.3 * k)) *
                    rotation_matrix(rotation_log(b, std::sin(0.2 * k))));
  return turns;
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
  return std::max(distance(a.centres, b.centres), distance(a.turns, b.turns));
}

inline double distance(const RigidMotion& a, const RigidMotion& b) {
  return std::max((a.turn - b.turn).norm(), (a.shift - b.shift).norm());
}

}  // namespace batten_test
