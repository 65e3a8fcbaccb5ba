// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/fair_curve.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"
#include "batten/fairing/curves/curve_dof_ordering.h"
#include "batten/fairing/curves/smoothing_spline_solver.h"

namespace batten {

namespace {

NoiseLevel known_of(const FairOptions& options) {
  if (options.smoothing == FairOptions::Smoothing::Noise) return {options.noise, 0};
  if (options.smoothing == FairOptions::Smoothing::Wavelength) return {0, options.wavelength};
  return {};
}

}  // namespace

FairCurve fair_points(const std::string& name, const std::vector<Vec3>& points,
                      const FairOptions& options) {
  const PointSequence sequence(
      name, points, options.corner_angle, options.corners, options.closed,
      options.reject_outliers ? PointSequence::Outliers::Drop : PointSequence::Outliers::Keep,
      known_of(options));
  check(name, options, sequence.closed);
  return SmoothingSplineSolver(name, points, sequence, options).run();
}

HermiteCurve interpolating_spline(const std::string& name, const std::vector<Vec3>& points,
                                  const FairOptions& options) {
  const PointSequence sequence(name, points, options.corner_angle, options.corners, options.closed);
  const CurveMesh mesh(sequence.chord, sequence.closed, sequence.corners);
  std::vector<Spring> springs;
  std::vector<std::pair<int, Vec3>> fixed_dofs;
  for (int i = 0; i < sequence.count(); ++i) {
    springs.push_back({mesh.locate(sequence.chord[i]), sequence.points[i]});
    fixed_dofs.emplace_back(mesh.position_dof(i), sequence.points[i]);
  }
  constexpr double mu = 1e8;  // makes second derivatives continuous to some digits
  const FairingEnergy energy(mesh, {}, 0, mu);
  return {mesh,
          PenalisedLeastSquares(mesh, springs, energy, fixed_dofs).solve(1e-6 * sequence.length())};
}

// Local fairing: an interval, a brush.

namespace {

// Consecutive segments of a curve, possibly across the seam: the first, and their number.
struct Run {
  int first, count;
};

// Groups the touched segments into runs. If a whole closed curve is touched, one node stays fixed.
std::vector<Run> runs_of(const HermiteCurve& curve, const std::vector<char>& touched) {
  const int n = curve.segment_count();
  std::vector<Run> runs;
  int start = 0;
  if (curve.closed()) {
    while (start < n && touched[start]) ++start;
    start %= n;
  }
  for (int i = 0; i < n; ++i) {
    const int s = (start + i) % n;
    if (!touched[s]) continue;
    if (!runs.empty() && (runs.back().first + runs.back().count) % n == s && runs.back().count < n)
      ++runs.back().count;
    else
      runs.push_back({s, 1});
  }
  return runs;
}

double length_of(const HermiteCurve& curve, int segment) {
  double length = 0;
  for (int i = 0; i < 4; ++i)
    length +=
        0.25 * curve.mesh().length(segment) * curve.evaluate({segment, (i + 0.5) / 4}, 1).norm();
  return length;
}

// Fairs the dofs of one run; the nodes at its ends stay fixed.
void fair_run(const HermiteCurve& curve, const Run& run,
              const std::function<double(double)>& strength, double wavelength, Points& dofs) {
  const CurveMesh& whole = curve.mesh();
  const int nodes = whole.node_count();
  std::vector<double> u = {0};
  std::vector<int> corners;
  double length = 0;
  for (int k = 0; k < run.count; ++k) {
    const int s = (run.first + k) % whole.segment_count();
    if (k > 0 && whole.is_corner(s)) corners.push_back(k);
    u.push_back(u.back() + whole.length(s));
    length += length_of(curve, s);
  }
  // φ and the wavelength refer to arc length; u runs at about `speed`.
  const double speed = length / u.back();
  const double lambda = std::pow(wavelength / (2 * std::numbers::pi * speed), 4);
  const CurveMesh mesh(u, false, corners);
  const CurveDofOrdering band(mesh);
  BandCholesky A;
  band.reset(A);
  Points right = Points::Zero(mesh.dof_count(), 3);
  std::vector<int> outer(mesh.dof_count());  // dof of the whole curve for each dof of the run
  const auto global = [&](int segment) {
    return whole.segment_dofs((run.first + segment) % whole.segment_count());
  };
  for (int k = 0; k < run.count; ++k) {
    const int s = (run.first + k) % whole.segment_count();
    const HermiteSegment segment(mesh.length(k));
    const HermiteSegment::Matrix M = segment.mass();
    const double a = whole.parameters()[s], h = whole.length(s);
    band.add(A, k,
             M + segment.bending(
                     {lambda * std::pow(strength(a), 4), lambda * std::pow(strength(a + h), 4)}));
    const auto local = mesh.segment_dofs(k), all = global(k);
    Eigen::Matrix<double, 4, 3> q;
    for (int i = 0; i < 4; ++i) {
      q.row(i) = curve.dofs().row(all[i]);
      outer[local[i]] = all[i];
    }
    const Eigen::Matrix<double, 4, 3> goal = M * q;
    for (int i = 0; i < 4; ++i) right.row(band.banded_index(local[i])) += goal.row(i);
  }
  std::vector<int> kept = {mesh.position_dof(0), mesh.position_dof(mesh.node_count() - 1)};
  // At the end of an open curve the slope is free.
  if (curve.closed() || run.first > 0) kept.push_back(mesh.slope_out(0));
  if (curve.closed() || run.first + run.count < nodes - 1)
    kept.push_back(mesh.slope_in(mesh.node_count() - 1));
  for (const int d : kept)
    A.fix(band.banded_index(d), curve.dofs().row(outer[d]).transpose(), right);
  if (!A.factorize())
    throw NoSolutionError(
        "a segment of a curve cannot be faired: its system is not positive definite");
  A.solve(right);
  for (int d = 0; d < mesh.dof_count(); ++d)
    if (std::find(kept.begin(), kept.end(), d) == kept.end())
      dofs.row(outer[d]) = right.row(band.banded_index(d));
}

HermiteCurve fair_where(const HermiteCurve& curve, const std::vector<char>& touched,
                        const std::function<double(double)>& strength, double extent,
                        double wavelength) {
  if (!(wavelength > 0) || !std::isfinite(wavelength))
    throw InputError("local fairing: found the wavelength " + format_number(wavelength) +
                     ", expected a length above 0");
  // Nodes dense enough for the shortest wave that remains, and for φ.
  const std::vector<Run> coarse = runs_of(curve, touched);
  std::vector<double> added;
  for (const Run& run : coarse)
    for (int k = 0; k < run.count; ++k) {
      const int s = (run.first + k) % curve.segment_count();
      constexpr int per_wave = 24, per_stretch = 72, most = 4000;
      const int pieces = static_cast<int>(std::clamp(
          std::ceil(length_of(curve, s) / std::min(wavelength / per_wave, extent / per_stretch)),
          1.0, 1.0 * most));
      for (int i = 1; i < pieces; ++i)
        added.push_back(curve.parameters()[s] + curve.mesh().length(s) * i / pieces);
    }
  const HermiteCurve fine = curve.with_nodes(added);
  Points dofs = fine.dofs();
  for (const Run& run : coarse) {
    // The same interval of the refined curve: everything that the coarse segments were.
    const auto node = [&](int coarse_node) {
      const double u = curve.parameters()[coarse_node];
      return static_cast<int>(
          std::lower_bound(fine.parameters().begin(), fine.parameters().end(), u) -
          fine.parameters().begin());
    };
    const int first = node(run.first), behind = run.first + run.count;
    const int last = behind <= curve.segment_count()
                         ? node(behind)
                         : node(behind - curve.segment_count()) + fine.segment_count();
    fair_run(fine, {first, last - first}, strength, wavelength, dofs);
  }
  return {fine.mesh(), dofs};
}

}  // namespace

HermiteCurve fair_interval(const HermiteCurve& curve, double from, double to, double wavelength) {
  const double whole = curve.end() - curve.start();
  double extent = to - from;
  if (curve.closed() && extent < 0) extent += whole;
  if (!(extent > 0) || !std::isfinite(from) || !std::isfinite(to))
    throw InputError("local fairing: found a segment from " + format_number(from) + " to " +
                     format_number(to) +
                     ", expected two parameters of the curve, the second above the first");
  if (!curve.closed() && (from >= curve.end() || to <= curve.start()))
    throw InputError("local fairing: found a segment from " + format_number(from) + " to " +
                     format_number(to) + " of a curve from " + format_number(curve.start()) +
                     " to " + format_number(curve.end()));
  std::vector<char> touched(curve.segment_count(), 0);
  for (int s = 0; s < curve.segment_count(); ++s)
    for (const double turn : {-whole, 0.0, whole})
      if (turn == 0 || curve.closed())
        touched[s] |=
            from + turn < curve.parameters()[s + 1] && from + extent + turn > curve.parameters()[s];
  const auto strength = [&](double u) {
    double into = u - from;
    if (curve.closed()) into -= whole * std::floor(into / whole);
    const double x = 2 * into / extent - 1;
    return std::abs(x) < 1 ? (1 - x * x) * (1 - x * x) : 0.0;
  };
  const double middle = curve.evaluate(from + 0.5 * extent, 1).norm();
  return fair_where(curve, touched, strength, extent * (middle > 0 ? middle : 1), wavelength);
}

HermiteCurve fair_brush(const HermiteCurve& curve, const Vec3& centre, double radius,
                        double wavelength) {
  if (!(radius > 0) || !std::isfinite(radius) || !centre.allFinite())
    throw InputError("local fairing: found a brush of radius " + format_number(radius) +
                     ", expected a length above 0");
  const CurvePoint nearest = curve.closest_point(centre);
  if (!(nearest.distance < radius))
    throw InputError("local fairing: the curve lies outside of the brush; it is " +
                     format_number(nearest.distance) + " away from its centre, and the radius is " +
                     format_number(radius));
  const auto strength = [&](double u) {
    const double x = (curve.evaluate(u) - centre).squaredNorm() / (radius * radius);
    return x < 1 ? (1 - x) * (1 - x) : 0.0;
  };
  std::vector<char> touched(curve.segment_count(), 0);
  constexpr int samples = 32;
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k <= samples && !touched[s]; ++k)
      touched[s] = strength(curve.parameters()[s] + curve.mesh().length(s) * k / samples) > 0;
  touched[curve.mesh().locate(nearest.u).segment] = 1;
  return fair_where(curve, touched, strength, 2 * radius, wavelength);
}

// Measures of fairness.

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

Fairness fairness(const HermiteCurve& curve) {
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
  double threshold =
      std::max(0.01 * result.largest_curvature, result.length > 0 ? 1e-6 / result.length : 0);
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
