// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/mesh_sequence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/errors.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

void check(const MeshSequence& sequence, const std::string& name) {
  if (sequence.frames.empty()) throw InputError(name + ": found no frames, expected one or more");
  const auto frame = [&](size_t k) { return name + ": frame " + std::to_string(k + 1); };
  for (size_t k = 0; k < sequence.frames.size(); ++k) {
    const Points& p = sequence.frames[k];
    if (p.rows() != sequence.node_count())
      throw InputError(frame(k) + " has " + std::to_string(p.rows()) + " nodes, expected " +
                       std::to_string(sequence.node_count()) + " as in the first frame");
    for (long v = 0; v < p.rows(); ++v)
      if (!p.row(v).allFinite() || !(p.row(v).cwiseAbs().maxCoeff() < 1e100))
        throw InputError(frame(k) + ": node " + std::to_string(v + 1) +
                         " has a coordinate that is not finite, or above 1e100");
  }
  if (sequence.times.size() != sequence.frames.size())
    throw InputError(name + ": found " + std::to_string(sequence.times.size()) + " times for " +
                     std::to_string(sequence.frames.size()) + " frames, expected one for each");
  for (size_t k = 0; k < sequence.times.size(); ++k)
    if (!std::isfinite(sequence.times[k]) ||
        (k > 0 && !(sequence.times[k] > sequence.times[k - 1])))
      throw InputError(frame(k) + " has a time that is not after that of the frame before");
}

double size_of(const MeshSequence& sequence) {
  if (sequence.frames.empty() || sequence.node_count() == 0) return 0;
  const Points& p = sequence.frames.front();
  return (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
}

std::vector<double> second_differences(const std::vector<Points>& frames) {
  std::vector<double> largest(frames.size(), 0);
  for (size_t k = 1; k + 1 < frames.size(); ++k)
    if (frames[k].rows() > 0)
      largest[k] = (frames[k + 1] - 2 * frames[k] + frames[k - 1]).rowwise().norm().maxCoeff();
  return largest;
}

FrameMeasures::FrameMeasures(const TriangleMesh& mesh, std::vector<Foot> feet)
    : mesh_(mesh), feet_(std::move(feet)), centres_(feet_.size()) {}

void FrameMeasures::add(int frame, const Points& p) {
  last_.push_back(p);
  if (last_.size() > 3) last_.pop_front();
  if (last_.size() == 3 && p.rows() > 0)
    max_second_difference_ = std::max(
        max_second_difference_, (last_[2] - 2 * last_[1] + last_[0]).rowwise().norm().maxCoeff());
  inverted_triangles_ += count_inverted_triangles(p);
  for (size_t f = 0; f < feet_.size(); ++f)
    if (frame >= feet_[f].first && frame <= feet_[f].last)
      centres_[f].push_back(VertexCombination::mean_of(feet_[f].vertices).at(p));
}

double FrameMeasures::foot_skate(int foot) const {
  const std::vector<Vec3>& centres = centres_[foot];
  Vec3 mean = Vec3::Zero();
  for (const Vec3& c : centres) mean += c / static_cast<double>(centres.size());
  double largest = 0;
  for (const Vec3& c : centres) largest = std::max(largest, (c - mean).norm());
  return largest;
}

long FrameMeasures::count_inverted_triangles(const Points& p) const {
  const MeshTopology& topology = mesh_.topology();
  const auto normal = [&](int t) -> Vec3 {
    const auto& corners = topology.triangles()[t];
    const Vec3 a = p.row(topology.node_of(corners[0])), b = p.row(topology.node_of(corners[1])),
               c = p.row(topology.node_of(corners[2]));
    return (b - a).cross(c - a);
  };
  long count = 0;
  for (int t = 0; t < topology.triangle_count(); ++t) {
    Vec3 around = Vec3::Zero();
    for (int corner = 0; corner < 3; ++corner)
      if (const int other = topology.across(t, corner); other >= 0) around += normal(other);
    count += normal(t).dot(around) < 0;
  }
  return count;
}

double stance_speed(const std::vector<Points>& frames, const std::vector<std::vector<int>>& feet,
                    const Vec3& direction, const Vec3& up) {
  if (frames.size() < 2)
    throw InputError("root motion: found fewer than two frames, expected two or more");
  if (feet.empty()) throw InputError("root motion: without feet, the speed must be given");
  std::vector<double> backwards;
  for (size_t k = 0; k + 1 < frames.size(); ++k) {
    double lowest = std::numeric_limits<double>::infinity(), step = 0;
    for (const auto& foot : feet) {
      const Vec3 a = centroid(frames[k], foot), b = centroid(frames[k + 1], foot);
      if ((a + b).dot(up) >= lowest) continue;
      lowest = (a + b).dot(up);
      step = (a - b).dot(direction);
    }
    backwards.push_back(step);
  }
  const auto middle = backwards.begin() + static_cast<long>(backwards.size() / 2);
  std::nth_element(backwards.begin(), middle, backwards.end());
  return *middle;
}

MeshSequence with_root_motion(const MeshSequence& sequence, int cycles, const Vec3& direction,
                              double speed) {
  const int count = sequence.frame_count();
  if (cycles < 1)
    throw InputError("root motion: found " + std::to_string(cycles) +
                     " cycles, expected 1 or more");
  if (count < 2) throw InputError("root motion: found fewer than two frames, expected two or more");
  const double apart =
      (sequence.frames.back() - sequence.frames.front()).rowwise().norm().maxCoeff();
  const int cycle = apart < 1e-6 * size_of(sequence) ? count - 1 : count;
  const double step = (sequence.times.back() - sequence.times.front()) / (count - 1);
  MeshSequence result;
  result.shells = sequence.shells;
  const int all = cycle < count ? cycles * cycle + 1 : cycles * cycle;
  for (int k = 0; k < all; ++k) {
    const Points& p = sequence.frames[k % cycle];
    result.frames.push_back(p.rowwise() + k * speed * direction.transpose());
    result.times.push_back(k < count ? sequence.times[k] : result.times.back() + step);
  }
  return result;
}

}  // namespace batten
