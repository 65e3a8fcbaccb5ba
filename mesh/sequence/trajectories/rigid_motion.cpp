// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

void need_frames(size_t found, int expected, const char* what) {
  if (found != static_cast<size_t>(expected))
    throw InputError("found " + std::to_string(found) + " " + what + " for a trajectory of " +
                     std::to_string(expected) + " frames");
}

}  // namespace

Vec3 centroid(const Points& p, const std::vector<int>& vertices) {
  if (vertices.empty()) return Vec3::Zero();
  const Vec3 from = p.row(vertices.front());
  Vec3 sum = Vec3::Zero();
  for (const int v : vertices) sum += p.row(v).transpose() - from;
  return from + sum / static_cast<double>(vertices.size());
}

Trajectory trajectory_of(const std::vector<Points>& frames, const std::vector<int>& vertices) {
  if (vertices.empty()) throw InputError("trajectory: found no vertices, expected one or more");
  Trajectory result;
  result.centres.resize(isize(frames), 3);
  for (int k = 0; k < isize(frames); ++k) {
    for (const int v : vertices)
      if (v < 0 || v >= frames[k].rows())
        throw InputError("trajectory: found vertex " + std::to_string(v + 1) + ", but frame " +
                         std::to_string(k + 1) + " has " + std::to_string(frames[k].rows()) +
                         " vertices");
    result.centres.row(k) = centroid(frames[k], vertices);
    result.rotations.push_back(k == 0 ? Mat3(Mat3::Identity())
                                      : fit_similarity(frames[0], frames[k], vertices, 1.0).R);
  }
  return result;
}

Trajectory root_trajectory(const std::vector<Points>& frames) {
  Trajectory root;
  root.centres.resize(static_cast<long>(frames.size()), 3);
  root.rotations.assign(frames.size(), Mat3::Identity());
  for (size_t k = 0; k < frames.size(); ++k)
    root.centres.row(static_cast<long>(k)) = frames[k].colwise().mean();
  return root;
}

Trajectory moved(const std::vector<RigidMotion>& motions, const Trajectory& trajectory) {
  need_frames(motions.size(), trajectory.frame_count(), "motions");
  Trajectory result = trajectory;
  for (int k = 0; k < trajectory.frame_count(); ++k) {
    result.centres.row(k) = motions[k](trajectory.centres.row(k).transpose());
    result.rotations[k] = motions[k].rotation * trajectory.rotations[k];
  }
  return result;
}

std::vector<RigidMotion> motions_between(const Trajectory& from, const Trajectory& to) {
  need_frames(to.rotations.size(), from.frame_count(), "frames of another trajectory");
  std::vector<RigidMotion> motions;
  for (int k = 0; k < from.frame_count(); ++k)
    motions.push_back(RigidMotion::about(from.centres.row(k).transpose(),
                                         to.rotations[k] * from.rotations[k].transpose(),
                                         to.centres.row(k).transpose()));
  return motions;
}

}  // namespace batten
