// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/node_rotations.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

/// Widths of the points across their longest direction below this fraction of their length count as
/// zero: the points are collinear.
constexpr double kCollinear = 1e-6;

Vec3 centroid_of(const Points& points, const std::vector<int>& nodes) {
  Vec3 sum = Vec3::Zero();
  for (const int v : nodes) sum += points.row(v).transpose();
  return sum / static_cast<double>(std::max<size_t>(nodes.size(), 1));
}

bool are_collinear(const Points& points, const std::vector<int>& nodes, const Vec3& centroid) {
  Mat3 scatter = Mat3::Zero();
  for (const int v : nodes) {
    const Vec3 d = points.row(v).transpose() - centroid;
    scatter += d * d.transpose();
  }
  const Vec3 widths = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvalues();
  return !(widths[1] > kCollinear * kCollinear * widths[2]);
}

}  // namespace

NodeRotations::NodeRotations(const ShellMesh& shells, std::span<const NonShellElement> elements,
                             const Points& before, const Points& after)
    : before_(before),
      after_(after),
      rings_(static_cast<size_t>(before.rows())),
      rotations_(rings_.size()) {
  largest_ = std::max(before.size() ? before.cwiseAbs().maxCoeff() : 0,
                      after.size() ? after.cwiseAbs().maxCoeff() : 0);
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto face = shells.face(f);
    elements_.emplace_back(face.begin(), face.end());
  }
  for (const NonShellElement& e : elements)
    if (e.nodes.size() > 1) elements_.push_back(e.nodes);
  start_.assign(static_cast<size_t>(before.rows()) + 1, 0);
  for (const auto& nodes : elements_)
    for (const int v : nodes) ++start_[v + 1];
  for (size_t v = 1; v < start_.size(); ++v) start_[v] += start_[v - 1];
  elements_of_.resize(start_.back());
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (int e = 0; e < isize(elements_); ++e)
    for (const int v : elements_[e]) elements_of_[next[v]++] = e;
}

std::vector<int> NodeRotations::nodes_around(std::vector<int> nodes) const {
  const size_t own = nodes.size();
  for (size_t i = 0; i < own; ++i)
    for (int k = start_[nodes[i]]; k < start_[nodes[i] + 1]; ++k) {
      const std::vector<int>& element = elements_[elements_of_[k]];
      nodes.insert(nodes.end(), element.begin(), element.end());
    }
  return sorted_unique(std::move(nodes));
}

NodeRotations::Ring NodeRotations::ring_of(int node) const {
  std::optional<Ring>& known = rings_[node];
  if (known) return *known;
  constexpr int kMostExtensions = 4;
  std::vector<int> ring = nodes_around({node});
  Vec3 centre = centroid_of(before_, ring);
  for (int k = 0; k < kMostExtensions && are_collinear(before_, ring, centre); ++k) {
    const size_t size = ring.size();
    ring = nodes_around(std::move(ring));
    if (ring.size() == size) break;
    centre = centroid_of(before_, ring);
  }
  Ring result{centre, Mat3::Identity(), false, 0};
  for (const int v : ring) {
    result.moved |= before_.row(v) != after_.row(v);
    result.extent = std::max(result.extent, (before_.row(v).transpose() - centre).norm());
  }
  if (result.moved) result.R = fit_similarity(before_, after_, ring, 1).R;
  known = result;
  return result;
}

const Mat3& NodeRotations::rotation_at(int node, const Ring& own) const {
  std::optional<Mat3>& known = rotations_[node];
  if (!known) known = extrapolated_rotation(node, own);
  return *known;
}

Mat3 NodeRotations::extrapolated_rotation(int node, const Ring& own) const {
  const Vec3 arm = before_.row(node).transpose() - own.centroid;
  if (!own.moved || !(arm.norm() > kCollinear * own.extent)) return own.R;
  const std::vector<int> ring = nodes_around({node});
  MatX offsets(isize(ring), 3), turns(isize(ring), 3);
  double largest = 0;
  for (int j = 0; j < isize(ring); ++j) {
    const Ring other = ring_of(ring[j]);
    const Vec3 turn = to_rotation_vector(other.R * own.R.transpose());
    offsets.row(j) = (other.centroid - own.centroid).transpose();
    turns.row(j) = turn.transpose();
    largest = std::max(largest, turn.norm());
  }
  Eigen::CompleteOrthogonalDecomposition<MatX> fit(isize(ring), 3);
  fit.setThreshold(1e-3);
  fit.compute(offsets);
  const MatX gradient = fit.solve(turns);
  Vec3 turn = (arm.transpose() * gradient).transpose();
  if (turn.norm() > largest) turn *= largest / turn.norm();
  return rotation_matrix(turn) * own.R;
}

double NodeRotations::rounding_angle(double extent) const {
  return 64 * std::numeric_limits<double>::epsilon() * largest_ / std::max(extent, 1e-300);
}

NodeRotations::Motion NodeRotations::of(std::span<const int> nodes) const {
  Motion motion;
  if (nodes.empty()) return motion;
  std::vector<Mat3> rotations;
  double rounding = 0;
  for (const int v : nodes) {
    const Ring ring = ring_of(v);
    rotations.push_back(rotation_at(v, ring));
    motion.is_identity &= !ring.moved;
    rounding = std::max(rounding, rounding_angle(ring.extent));
  }
  if (motion.is_identity) return motion;
  motion.R = mean_rotation(rotations, std::vector<double>(rotations.size(), 1.0));
  for (const Mat3& R : rotations)
    motion.spread = std::max(motion.spread, Eigen::AngleAxisd(motion.R.transpose() * R).angle());
  motion.is_rotated = Eigen::AngleAxisd(motion.R).angle() > rounding;
  if (!motion.is_rotated) motion.R = Mat3::Identity();
  const std::vector<int> all(nodes.begin(), nodes.end());
  motion.translation = centroid_of(after_, all) - motion.R * centroid_of(before_, all);
  return motion;
}

}  // namespace batten
