// SPDX-License-Identifier: MPL-2.0
// Fairing of few points, whose noise cannot be distinguished from their shape.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "batten/core/geometry.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/smoothing_spline_solver.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

std::vector<Vec3> random_points(int seed, int count) {
  std::mt19937 engine(static_cast<unsigned>(seed));
  std::normal_distribution<double> gauss(0, 1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = gauss(engine), y = gauss(engine), z = gauss(engine);
    switch (seed % 3) {
      case 0:
        points.emplace_back(x, y, 0);
        break;
      case 1:
        points.emplace_back(i, (i % 2 == 0 ? 1 : -1) * (0.5 + 0.2 * y), 0);
        break;
      default:
        points.emplace_back(i + 0.3 * x, y, 0.3 * z);
    }
  }
  return points;
}

double path_length(const std::vector<Vec3>& points) {
  double sum = 0;
  for (size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

/// Largest distance of the curve from the polyline, over the longest chord.
double overshoot(const HermiteCurve& curve, const std::vector<Vec3>& points) {
  double longest = 0, worst = 0;
  for (size_t i = 1; i < points.size(); ++i)
    longest = std::max(longest, (points[i] - points[i - 1]).norm());
  for (int k = 0; k <= 500; ++k) {
    const Vec3 x = curve.evaluate(curve.end() * k / 500);
    double nearest = INFINITY;
    for (size_t i = 1; i < points.size(); ++i)
      nearest = std::min(nearest, chord_excess(x, points[i - 1], points[i], 0));
    worst = std::max(worst, nearest);
  }
  return worst / longest;
}

}  // namespace

TEST_CASE("few points stay where they are, open and closed, with any shape", "[fairing][curves]") {
  for (int seed = 0; seed < 300; ++seed) {
    const int count = 3 + seed % 12;
    const std::vector<Vec3> points = random_points(seed, count);
    const double size = bounding_box(points).diagonal().norm();
    for (const bool closed : {false, true}) {
      INFO("seed " << seed << ", " << count << " points, closed " << closed);
      FairOptions options;
      options.closed = closed;
      const FairCurve fair = fair_points("few", points, options);
      CHECK(fair.deviation.max <= 1e-12 * size);
      CHECK(fair.outliers.empty());
      REQUIRE(fair.parameters.size() == points.size());
      for (size_t i = 0; i < points.size(); ++i)
        CHECK((fair.curve.evaluate(fair.parameters[i]) - points[i]).norm() <= 1e-12 * size);
      const Fairness f = fairness(fair.curve);
      CHECK(f.largest_jump <= 1e-9 * f.largest_curvature);
    }
  }
}

TEST_CASE("curves through few points do not overshoot", "[fairing][curves]") {
  FairOptions options;
  options.corner_angle = 180;
  double sum = 0, chord_sum = 0;
  for (int seed = 0; seed < 300; ++seed) {
    const std::vector<Vec3> points = random_points(seed, 5 + seed % 10);
    INFO("seed " << seed);
    const HermiteCurve curve = fair_points("few", points, options).curve;
    const double over = overshoot(curve, points);
    CHECK(over < 0.35);
    sum += over;
    CHECK(curve.length() < 1.15 * path_length(points));
    chord_sum += overshoot(interpolating_spline("few", points, options), points);
  }
  CHECK(sum < 0.75 * chord_sum);  // less than splines over chord lengths
}

TEST_CASE("a stated noise, deviation or wavelength moves few points", "[fairing][curves]") {
  std::vector<Vec3> points;
  for (int i = 0; i < 10; ++i) points.emplace_back(i, i % 2 == 0 ? 0.1 : -0.1, 0);
  FairOptions options;
  CHECK(fair_points("few", points, options).deviation.max < 1e-12);
  options.noise = options.deviation = 0.15;
  options.wavelength = 6;
  for (const auto how : {FairOptions::Smoothing::Noise, FairOptions::Smoothing::Deviation,
                         FairOptions::Smoothing::Wavelength}) {
    options.smoothing = how;
    const FairCurve fair = fair_points("few", points, options);
    CHECK(fair.deviation.max > 0.05);
    CHECK(fair.deviation.max <= 0.15);
  }
  // Strokes drawn by hand are noisy, however few points they have.
  options = {};
  options.drawn_by_hand = true;
  CHECK(fair_points("few", points, options).deviation.max > 0.05);
}

TEST_CASE("exact points move by twice their estimated noise at most", "[fairing][curves]") {
  using std::numbers::pi;
  for (int seed = 0; seed < 120; ++seed) {
    const int count = 15 + seed % 30, modes = 1 + seed % 4;
    std::mt19937 engine(static_cast<unsigned>(seed));
    std::normal_distribution<double> gauss(0, 1);
    std::vector<double> a(static_cast<size_t>(4 * modes));
    for (double& value : a) value = gauss(engine);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
      const double inner = i > 0 && i + 1 < count ? 0.1 * gauss(engine) : 0;
      const double t = (i + (seed % 2) * inner) / (count - 1);
      Vec3 x(10 * t, 0, 0);
      for (int k = 0; k < modes; ++k)
        for (int d = 0; d < 2; ++d)
          x[d] += 0.6 / (k + 1) *
                  (a[4 * k + d] * std::sin(2 * pi * (k + 1) * t) +
                   a[4 * k + 2 + d] * std::cos(2 * pi * (k + 1) * t));
      points.push_back(x);
    }
    INFO("seed " << seed);
    const double size = bounding_box(points).diagonal().norm();
    const FairCurve fair = fair_points("exact", points);
    CHECK(fair.deviation.rms <= 2 * fair.noise + 1e-6 * size);
  }
}

TEST_CASE("uneven spacing of exact points is no noise", "[fairing][curves]") {
  using std::numbers::pi;
  std::vector<double> moved;
  for (int seed = 0; seed < 40; ++seed) {
    std::mt19937 engine(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    std::vector<Vec3> points;
    for (int i = 0; i <= 60; ++i) {
      const double t = (i + (i > 0 && i < 60 ? uniform(engine) : 0)) / 60;
      points.emplace_back(10 * t, std::sin(4 * pi * t) + 0.3 * std::cos(6 * pi * t + seed), 0);
    }
    const FairCurve fair = fair_points("exact", points);
    moved.push_back(fair.deviation.max / bounding_box(points).diagonal().norm());
  }
  std::nth_element(moved.begin(), moved.begin() + 20, moved.end());
  CHECK(moved[20] < 1e-5);
}

TEST_CASE("parameters of points on a straight line are chord lengths", "[fairing][curves]") {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {4, 0, 0}, {5, 0, 0}};
  const PointSequence line("line", points, 180, {}, {});
  CHECK(interpolating_parameters(line) == line.chord);
  // Chords beside a turn count more, those beside a corner do not.
  const std::vector<Vec3> bent = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 1, 0}};
  const std::vector<double> u = interpolating_parameters(PointSequence("bent", bent, 180, {}, {}));
  CHECK(u[1] == Approx(1 + 0.75 * 0.5 * std::numbers::pi));
  const PointSequence cornered("bent", bent, 180, std::vector<int>{1, 2}, {});
  CHECK(interpolating_parameters(cornered) == cornered.chord);
}
