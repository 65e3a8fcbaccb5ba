// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/neighbour_edge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include <Eigen/Geometry>

#include "batten/core/containers.h"

namespace batten {
namespace {

// The closest point of all neighbours to a point: neighbour, segment, and fraction of the segment.
struct Foot {
  double distance2 = std::numeric_limits<double>::infinity();
  size_t neighbour = 0, segment = 0;
  double fraction = 0;
};

Foot closest(const std::vector<NeighbourCurve>& neighbours, const std::vector<size_t>& candidates,
             const Vec3& p) {
  Foot best;
  for (const size_t n : candidates) {
    const std::vector<NeighbourSample>& samples = neighbours[n].samples;
    for (size_t i = 0; i + 1 < samples.size(); ++i) {
      const Vec3 a = samples[i].point, d = samples[i + 1].point - a;
      const double s =
          d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0., 1.) : 0;
      const double distance2 = (a + s * d - p).squaredNorm();
      if (distance2 < best.distance2) best = {distance2, n, i, s};
    }
  }
  return best;
}

}  // namespace

std::shared_ptr<const NeighbourEdge> NeighbourEdge::along(
    const HermiteCurve& curve, const std::vector<NeighbourCurve>& neighbours, double tolerance) {
  constexpr int kProbes = 64, kSteps = 512;
  const auto foot_at = [&](double f, const std::vector<size_t>& candidates) {
    return closest(neighbours, candidates,
                   curve.evaluate(curve.start() + f * (curve.end() - curve.start())));
  };
  // At a corner, the closest curve may be one of the next edge: only curves that are the closest
  // ones to a point inside the edge are candidates.
  std::vector<size_t> all(neighbours.size());
  std::iota(all.begin(), all.end(), size_t{0});
  std::set<size_t> beside;
  for (int i = 0; i < kProbes; ++i) {
    const Foot foot = foot_at((i + 0.5) / kProbes, all);
    if (!(foot.distance2 <= tolerance * tolerance)) return nullptr;
    beside.insert(foot.neighbour);
  }
  const std::vector<size_t> candidates(beside.begin(), beside.end());
  std::shared_ptr<NeighbourEdge> edge(new NeighbourEdge);
  for (int i = 0; i <= kSteps; ++i) {
    const Foot foot = foot_at(static_cast<double>(i) / kSteps, candidates);
    edge->points_.push_back(
        curve.evaluate(curve.start() + i * (curve.end() - curve.start()) / kSteps));
    if (!(foot.distance2 <= tolerance * tolerance)) return nullptr;
    edge->distance_ = std::max(edge->distance_, std::sqrt(foot.distance2));
    const NeighbourCurve& on = neighbours[foot.neighbour];
    const NeighbourSample &a = on.samples[foot.segment], &b = on.samples[foot.segment + 1];
    edge->given_.push_back((foot.fraction < 0.5 ? a : b).point);
    edge->into_.push_back((1 - foot.fraction) * a.into + foot.fraction * b.into);
    edge->curvature_.push_back((1 - foot.fraction) * a.curvature + foot.fraction * b.curvature);
    if (i == 0) edge->continuity_ = on.continuity;
    if (std::find(edge->names_.begin(), edge->names_.end(), on.name) == edge->names_.end())
      edge->names_.push_back(on.name);
  }
  return edge;
}

Vec3 NeighbourEdge::interpolated(const std::vector<Vec3>& values, double f) const {
  const double at = std::clamp(f, 0.0, 1.0) * (isize(values) - 1);
  const size_t i = std::min(static_cast<size_t>(at), values.size() - 2);
  const double s = at - static_cast<double>(i);
  return (1 - s) * values[i] + s * values[i + 1];
}

Vec3 NeighbourEdge::into(double f, const Vec3& tangent) const {
  const Vec3 way = interpolated(into_, f), t = tangent.normalized();
  return (way - way.dot(t) * t).normalized();
}

// Derivative of the edge at a sample, by differences of second order.
Vec3 NeighbourEdge::along(int i) const {
  const int last = isize(points_) - 1;
  if (i == 0) return -3 * points_[0] + 4 * points_[1] - points_[2];
  if (i == last) return 3 * points_[last] - 4 * points_[last - 1] + points_[last - 2];
  return points_[i + 1] - points_[i - 1];
}

void NeighbourEdge::sample(bool left, Points& positions, Points& normals) const {
  constexpr int kStep = 8;  // of the points of the edge
  const auto count = isize(points_);
  for (int i = 0; i < count; i += kStep) {
    const long row = positions.rows();
    positions.conservativeResize(row + 1, 3);
    normals.conservativeResize(row + 1, 3);
    positions.row(row) = given_[i];
    normals.row(row) = (left ? 1 : -1) * into_[i].cross(along(i)).normalized();
  }
}

Vec3 NeighbourEdge::normal_near(const Vec3& x) const {
  double least = std::numeric_limits<double>::infinity();
  Vec3 normal = Vec3::Zero();
  for (size_t i = 0; i + 1 < points_.size(); ++i) {
    const Vec3 a = points_[i], d = points_[i + 1] - a;
    const double s = std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    const double distance2 = (a + s * d - x).squaredNorm();
    if (!(distance2 < least)) continue;
    least = distance2;
    const auto k = static_cast<int>(i);
    normal = ((1 - s) * into_[i] + s * into_[i + 1])
                 .cross((1 - s) * along(k) + s * along(k + 1))
                 .normalized();
  }
  return normal;
}

Vec3 NeighbourEdge::curvature(double f) const { return interpolated(curvature_, f); }

}  // namespace batten
