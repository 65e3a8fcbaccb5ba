// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/sweep.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/fem/curves/cubic.h"

namespace batten {
namespace {

constexpr int kSteps = 96;           // along the rails: 4 degrees per step for a full turn
constexpr int kSectionSamples = 48;  // of the sections, for twist and mismatch
// Of the longest chord: below it the rails meet and the frame is undefined.
constexpr double kMinChord = 1e-3;

Mat3 rotation(const Vec3& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// The smallest rotation that takes the unit vector a to b.
Mat3 between(const Vec3& a, const Vec3& b) {
  const Vec3 v = a.cross(b);
  const double c = a.dot(b);
  if (c < -1 + 1e-9) return Mat3::Identity();
  Mat3 K;
  K << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Mat3::Identity() + K + K * K / (1 + c);
}

// 0 at `from`, 1 at `to`, smooth in between.
double ramp(double x, double from, double to) {
  return smooth_step(std::clamp((x - from) / (to - from), 0.0, 1.0));
}

}  // namespace

Sweep::Sweep(const Curve& c0, const Curve& c1, const Curve& r0, const Curve& r1) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (int k = 0; k <= kSteps; ++k) {
    const double v = static_cast<double>(k) / kSteps;
    const Vec3 from = r0(v).x, chord = r1(v).x - from;
    const double length = chord.norm();
    least = std::min(least, length);
    most = std::max(most, length);
    if (k == 0) origin0_ = from, length0_ = length;
    if (k == kSteps) origin1_ = from, length1_ = length;
    chords_.push_back(length > 0 ? Vec3(chord / length) : Vec3(Vec3::UnitX()));
    transported_.push_back(k == 0
                               ? Mat3(Mat3::Identity())
                               : Mat3(between(chords_[static_cast<size_t>(k) - 1], chords_.back()) *
                                      transported_.back()));
  }
  if (!(least > kMinChord * most)) {
    mismatch_ = std::numeric_limits<double>::infinity();
    return;
  }
  const Vec3 e = chords_.front();
  const Mat3 back = transported_.back().transpose();
  std::vector<Vec3> first, last;
  double cosine = 0, sine = 0, bulge0 = 0, bulge1 = 0;
  for (int k = 0; k <= kSectionSamples; ++k) {
    const double u = static_cast<double>(k) / kSectionSamples;
    first.push_back((c0(u).x - origin0_) / length0_);
    last.push_back(back * (c1(u).x - origin1_) / length1_);
    const Vec3 a = first.back() - first.back().dot(e) * e, b = last.back() - last.back().dot(e) * e;
    cosine += a.dot(b);
    sine += e.dot(a.cross(b));
    bulge0 += a.squaredNorm();
    bulge1 += b.squaredNorm();
  }
  const double alike = std::hypot(cosine, sine);
  const double turn = alike > 1e-24 ? std::atan2(sine, cosine) : 0;
  // Fractions of the other section's bulge: below the first one a section counts as straight.
  constexpr double kStraight = 0.05, kBulged = 0.25, kQuarter = std::numbers::pi / 2;
  constexpr double kMaxTwist = 130 * std::numbers::pi / 180;
  const double twist = turn * ramp(std::abs(turn), std::numbers::pi, kMaxTwist) *
                       ramp(alike / std::max({bulge0, bulge1, 1e-24}), kStraight, kBulged);
  slerp_angle_ = std::clamp(twist, -kQuarter, kQuarter);
  twist_ = twist - slerp_angle_;
  to_first_ = rotation(e, -twist_) * back;
  const Mat3 untwist = rotation(e, -twist);
  double sum = 0;
  for (size_t k = 0; k < first.size(); ++k) sum += (untwist * last[k] - first[k]).squaredNorm();
  mismatch_ = std::sqrt(sum / static_cast<double>(first.size()));
}

Mat3 Sweep::transport(double v, const Vec3& e) const {
  const auto k = static_cast<size_t>(std::clamp(std::floor(v * kSteps), 0.0, kSteps - 1.0));
  return between(chords_[k], e) * transported_[k];
}

Sweep::Weights Sweep::across(double v) const {
  const double sine = std::sin(slerp_angle_);
  if (std::abs(sine) < 1e-6) return {1 - v, v, -1, 1};
  const double from = (1 - v) * slerp_angle_, to = v * slerp_angle_;
  return {std::sin(from) / sine, std::sin(to) / sine, -slerp_angle_ * std::cos(from) / sine,
          slerp_angle_ * std::cos(to) / sine};
}

Sweep::Jet Sweep::at(double v, const PointAndSlope& c0, const PointAndSlope& c1,
                     const PointAndSlope& r0, const PointAndSlope& r1) const {
  const Vec3 chord = r1.x - r0.x, chord_v = r1.slope - r0.slope;
  const double length = chord.norm();
  const Vec3 e = chord / length;
  const double length_v = e.dot(chord_v);
  const Vec3 e_v = (chord_v - length_v * e) / length;
  const Vec3& first = chords_.front();
  const Mat3 turn = transport(v, e) * rotation(first, v * twist_);
  const Weights w = across(v);
  // Interpolates points, or derivatives, of the two sections.
  const auto between_sections = [&](const Vec3& a, const Vec3& b, double along_a, double along_b,
                                    double across_a, double across_b) {
    return Vec3(across_a * a + across_b * b +
                ((along_a - across_a) * first.dot(a) + (along_b - across_b) * first.dot(b)) *
                    first);
  };
  const Vec3 a0 = (c0.x - origin0_) / length0_, a1 = to_first_ * (c1.x - origin1_) / length1_;
  const Vec3 a0_u = c0.slope / length0_, a1_u = to_first_ * c1.slope / length1_;
  const Vec3 local = turn * between_sections(a0, a1, 1 - v, v, w.first, w.last);
  const Vec3 local_v = turn * between_sections(a0, a1, -1, 1, w.first_v, w.last_v);
  // P' = (e × e') × P, and the twist is a rotation about e.
  const Vec3 spin = e.cross(e_v) + twist_ * e;
  Jet jet;
  jet.x = r0.x + length * local;
  jet.by_u = length * (turn * between_sections(a0_u, a1_u, 1 - v, v, w.first, w.last));
  jet.by_v = r0.slope + length_v * local + length * (spin.cross(local) + local_v);
  return jet;
}

}  // namespace batten
