// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/fairness.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"

namespace batten {

namespace {

struct CurvatureSample {
  double speed = 0;
  Vec3 curvature = Vec3::Zero();  // curvature vector, towards the centre of curvature
  double change = 0;              // |dκ/ds|, κ = |curvature|
};

CurvatureSample curvature_sample(const HermiteCurve& curve, CurveMesh::SegmentPoint at) {
  const Vec3 d1 = curve.evaluate(at, 1), d2 = curve.evaluate(at, 2), d3 = curve.evaluate(at, 3);
  CurvatureSample sample;
  sample.speed = d1.norm();
  if (!(sample.speed > 0)) return sample;
  const double v2 = sample.speed * sample.speed, v3 = v2 * sample.speed;
  const Vec3 binormal = d1.cross(d2);
  sample.curvature = binormal.cross(d1) / (v2 * v2);
  // κ = |X' × X''| / |X'|³, differentiated by u and divided by the speed.
  const double area = binormal.norm();
  const double area_change = area > 0 ? binormal.dot(d1.cross(d3)) / area : d1.cross(d3).norm();
  sample.change = std::abs(area_change / v3 - 3 * area * d1.dot(d2) / (v3 * v2)) / sample.speed;
  return sample;
}

struct Counts {
  int extrema = 0, inflections = 0;
};

// Counts extrema and inflections along the samples. It keeps its state, so that a second lap can
// follow.
class WaveCounter {
 public:
  explicit WaveCounter(double threshold) : threshold_(threshold) {}
  Counts counts;

  void add(const Vec3& curvature) {
    if (curvature.norm() > threshold_) {
      if (last_.dot(curvature) < 0) {
        sign_ = -sign_;
        ++counts.inflections;
      }
      last_ = curvature;
    }
    turn(sign_ * curvature.norm());
  }

  // An extremum counts once the curvature has come back from it by more than the threshold.
  void turn(double k) {
    if (first_) high_ = low_ = k;
    first_ = false;
    high_ = std::max(high_, k);
    low_ = std::min(low_, k);
    if (direction_ <= 0 && k > low_ + threshold_) {
      counts.extrema += direction_ < 0;
      direction_ = 1;
      high_ = low_ = k;
    } else if (direction_ >= 0 && k < high_ - threshold_) {
      counts.extrema += direction_ > 0;
      direction_ = -1;
      high_ = low_ = k;
    }
  }

 private:
  double threshold_, sign_ = 1, high_ = 0, low_ = 0;
  int direction_ = 0;
  bool first_ = true;
  Vec3 last_ = Vec3::Zero();  // last sample large enough to have a direction
};

bool cut_before(const HermiteCurve& curve, int segment) {
  return curve.mesh().is_corner(segment) || (segment == 0 && !curve.closed());
}

}  // namespace

Fairness fairness(const HermiteCurve& curve, double scale) {
  static const SegmentRule rule = gauss_legendre(8);
  Fairness result;
  const int segments = curve.segment_count();
  for (int s = 0; s < segments; ++s) {
    const double h = curve.mesh().length(s);
    for (long p = 0; p < rule.s.size(); ++p) {
      const CurvatureSample sample = curvature_sample(curve, {s, rule.s[p]});
      const double ds = h * rule.weights[p] * sample.speed;
      result.length += ds;
      result.bending += ds * sample.curvature.squaredNorm();
      result.variation += ds * sample.change * sample.change;
    }
    if (!cut_before(curve, s)) {
      const Vec3 before = curvature_sample(curve, {s == 0 ? segments - 1 : s - 1, 1}).curvature;
      result.largest_jump = std::max(result.largest_jump,
                                     (curvature_sample(curve, {s, 0}).curvature - before).norm());
    }
  }

  constexpr int per_segment = 12;
  std::vector<std::vector<Vec3>> samples(segments);
  for (int s = 0; s < segments; ++s)
    for (int k = 0; k <= per_segment; ++k) {
      samples[s].push_back(
          curvature_sample(curve, {s, static_cast<double>(k) / per_segment}).curvature);
      result.largest_curvature = std::max(result.largest_curvature, samples[s].back().norm());
    }
  // Smaller waves are invisible, or come from rounding of the coordinates.
  double threshold = std::max(0.01 * std::max(result.largest_curvature, scale),
                              result.length > 0 ? 1e-6 / result.length : 0);
  for (int s = 0; s < segments; ++s) {
    const double chord = (curve.evaluate({s, 1}) - curve.evaluate({s, 0})).norm();
    if (chord > 0)
      threshold = std::max(threshold,
                           4e-15 * curve.evaluate({s, 0}).cwiseAbs().maxCoeff() / (chord * chord));
  }
  int first = 0;
  while (first < segments && !cut_before(curve, first)) ++first;
  const bool around = first == segments;  // closed curve without corners: the second lap counts
  WaveCounter counter(threshold);
  Counts before;
  for (int lap = 0; lap < (around ? 2 : 1); ++lap) {
    before = counter.counts;
    for (int i = 0; i < segments; ++i) {
      const int s = around ? i : (first + i) % segments;
      if (!around && cut_before(curve, s) && i > 0) {
        const Counts so_far = counter.counts;
        counter = WaveCounter(threshold);
        counter.counts = so_far;
      }
      for (const Vec3& k : samples[s]) counter.add(k);
    }
  }
  result.extrema = counter.counts.extrema - (around ? before.extrema : 0);
  result.inflections = counter.counts.inflections - (around ? before.inflections : 0);
  return result;
}

std::vector<CurvatureCombSample> curvature_comb(const HermiteCurve& curve, int teeth) {
  std::vector<CurvatureCombSample> comb;
  const double whole = curve.end() - curve.start();
  for (int s = 0; s < curve.segment_count(); ++s) {
    const double h = curve.mesh().length(s);
    const int n = std::max(1, static_cast<int>(std::lround(teeth * h / whole)));
    for (int k = 0; k <= n; ++k) {
      const double x = static_cast<double>(k) / n;
      const CurvatureSample sample = curvature_sample(curve, {s, x});
      const double size = sample.curvature.norm();
      comb.push_back({curve.parameters()[s] + x * h, curve.evaluate({s, x}),
                      size > 0 ? Vec3(-sample.curvature / size) : Vec3::Zero(), size});
    }
  }
  return comb;
}

}  // namespace batten
