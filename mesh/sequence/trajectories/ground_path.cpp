// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/ground_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

constexpr int kParts = 8;  // subdivisions of each span for arc lengths

// Gauss-Legendre quadrature on [0, 1] with five points.
constexpr std::array<double, 5> kGaussPoints = {0.046910077030668004, 0.230765344947158454, 0.5,
                                                0.769234655052841546, 0.953089922969331996};
constexpr std::array<double, 5> kGaussWeights = {0.118463442528094544, 0.239314335249683234,
                                                 0.284444444444444444, 0.239314335249683234,
                                                 0.118463442528094544};

double length_between(const PiecewiseCubic& curve, double from, double to) {
  double sum = 0;
  for (int i = 0; i < 5; ++i)
    sum += kGaussWeights[i] * curve.slope(from + kGaussPoints[i] * (to - from)).norm();
  return sum * (to - from);
}

Vec3 unit(const Vec3& up) {
  if (!(up.norm() > 0) || !up.allFinite())
    throw InputError("path: the up direction has length 0 or is not finite");
  return up.normalized();
}

Points on_ground(const Points& points, const Vec3& up) {
  return points - (points * up) * up.transpose();
}

/// Cumulative chord lengths of a polyline, from 0.
std::vector<double> chords(const Points& p) {
  std::vector<double> u = {0};
  for (int k = 1; k < p.rows(); ++k) u.push_back(u.back() + (p.row(k) - p.row(k - 1)).norm());
  return u;
}

}  // namespace

GroundPath::GroundPath(PiecewiseCubic curve, const Vec3& up)
    : curve_(std::move(curve)), up_(unit(up)) {
  const std::vector<double>& knots = curve_.knots();
  u_ = {knots.front()};
  lengths_ = {0};
  for (int i = 0; i + 1 < isize(knots); ++i)
    for (int part = 1; part <= kParts; ++part) {
      const double to =
          part == kParts ? knots[i + 1] : knots[i] + (knots[i + 1] - knots[i]) * part / kParts;
      lengths_.push_back(lengths_.back() + length_between(curve_, u_.back(), to));
      u_.push_back(to);
    }
}

GroundPath GroundPath::through(const std::vector<Vec3>& points, const Vec3& up) {
  if (points.size() < 2)
    throw InputError("path: found " + std::to_string(points.size()) +
                     " points, expected 2 or more");
  Points p(isize(points), 3);
  for (int i = 0; i < isize(points); ++i) p.row(i) = points[i];
  if (!p.allFinite()) throw InputError("path: a coordinate is not finite");
  p = on_ground(p, unit(up));
  const std::vector<double> u = chords(p);
  for (size_t i = 1; i < u.size(); ++i)
    if (!(u[i] - u[i - 1] > 1e-12 * u.back()))
      throw InputError("path: points " + std::to_string(i) + " and " + std::to_string(i + 1) +
                       " coincide on the ground");
  return {PiecewiseCubic::through(u, p, PiecewiseCubic::Ends::Natural), up};
}

double GroundPath::length_to(double u) const {
  if (u <= u_.front()) return (u - u_.front()) * curve_.slope(u).norm();
  if (u >= u_.back()) return length() + (u - u_.back()) * curve_.slope(u).norm();
  const auto i = std::upper_bound(u_.begin(), u_.end(), u) - u_.begin() - 1;
  return lengths_[i] + length_between(curve_, u_[i], u);
}

double GroundPath::parameter(double s) const {
  const auto next = std::upper_bound(lengths_.begin(), lengths_.end(), s);
  const auto i = std::clamp<long>(next - lengths_.begin() - 1, 0, isize(u_) - 2);
  // Newton's method, with bisection if it would leave the bracket.
  double low = u_[i], high = u_[i + 1];
  double u = low + (high - low) * (s - lengths_[i]) / (lengths_[i + 1] - lengths_[i]);
  for (int iteration = 0; iteration < 60; ++iteration) {
    u = u >= low && u <= high ? u : (low + high) / 2;
    const double off = lengths_[i] + length_between(curve_, u_[i], u) - s;
    if (off == 0) break;
    (off > 0 ? high : low) = u;
    const double step = off / curve_.slope(u).norm();
    u -= step;
    if (std::abs(step) <= 1e-15 * (u_.back() - u_.front())) break;
  }
  return std::clamp(u, u_[i], u_[i + 1]);
}

Vec3 GroundPath::at(double s) const { return frame(s).translation; }

RigidMotion GroundPath::frame(double s) const {
  const double u = parameter(std::clamp(s, 0.0, length())), range = u_.back() - u_.front();
  Vec3 along = curve_.slope(u);
  if (!(along.norm() > 1e-9 * length() / range))  // a cusp: use the direction across it
    along = curve_.at(u + 1e-3 * range) - curve_.at(u - 1e-3 * range);
  Mat3 rotation;
  rotation.col(0) = (along - along.dot(up_) * up_).normalized();
  rotation.col(1) = up_.cross(rotation.col(0));
  rotation.col(2) = up_;
  const bool on_path = s >= 0 && s <= length();
  return {rotation, on_path ? curve_.at(u)
                            : Vec3(curve_.at(u) + (s < 0 ? s : s - length()) * rotation.col(0))};
}

FittedPath fit_path(const Points& centres, const PathOptions& options) {
  const int frames = static_cast<int>(centres.rows());
  if (frames < 2)
    throw InputError("path: found " + std::to_string(frames) + " frames, expected 2 or more");
  if (options.spans < 0)
    throw InputError("path: found segments = " + std::to_string(options.spans) +
                     ", expected 0 or more");
  const Vec3 up = unit(options.up);
  const Points p = on_ground(centres, up);
  const std::vector<double> u = chords(p);
  if (!(u.back() > 1e-12 * p.cwiseAbs().maxCoeff()))
    throw InputError("path: all frames are at the same point on the ground");
  const int spans = options.spans > 0 ? options.spans : std::clamp(frames / 30, 1, 12);
  const int samples = std::max(frames, 8 * spans);
  std::vector<double> even(samples + 1);
  Points values(samples + 1, 3);
  for (int i = 0, k = 0; i <= samples; ++i) {
    even[i] = u.back() * i / samples;
    while (k + 2 < frames && u[k + 1] < even[i]) ++k;
    const double fraction =
        u[k + 1] > u[k] ? std::clamp((even[i] - u[k]) / (u[k + 1] - u[k]), 0.0, 1.0) : 0;
    values.row(i) = p.row(k) + fraction * (p.row(k + 1) - p.row(k));
  }
  FittedPath result{{PiecewiseCubic::fitted(even, values, spans), up}, {}};
  for (const double at : u) result.lengths.push_back(result.path.length_to(at));
  return result;
}

std::vector<RigidMotion> path_motions(const FittedPath& from, const GroundPath& to,
                                      PathLengths lengths) {
  const double scale = lengths == PathLengths::Normalised ? to.length() / from.path.length() : 1.0;
  std::vector<RigidMotion> motions;
  for (const double s : from.lengths)
    motions.push_back(to.frame(scale * s) * from.path.frame(s).inverse());
  return motions;
}

}  // namespace batten
