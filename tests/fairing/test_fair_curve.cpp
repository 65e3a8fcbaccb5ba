// SPDX-License-Identifier: MPL-2.0
// Smoothing splines: springs to the data and bending energy, for a whole curve and a part, with
// conditions.
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "batten/fairing/curves/fair_curve.h"

#include "batten/core/errors.h"
#include "batten/fairing/corners/point_sequence.h"
#include "batten/fairing/curves/penalised_least_squares.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

Vec3 roof(double s) {
  const double x = 2 * s - 1;
  return {2.2 * s, 0.1 * x * x,
          0.45 * (1 - 0.9 * std::pow(std::abs(x), 3)) + 0.05 * std::sin(2.5 * x)};
}

Vec3 loop(double s) {
  const double a = 2 * pi * s;
  return {2 * std::cos(a), std::sin(a), 0.2 * std::sin(2 * a)};
}

struct Noisy {
  std::vector<Vec3> points;
  double noise = 0;  // rms distance from the exact curve
};

double distance_to(const std::function<Vec3(double)>& x, const Vec3& p) {
  double best = 1e300, at = 0;
  for (int i = 0; i <= 500; ++i)
    if (const double d = (x(i / 500.0) - p).norm(); d < best) {
      best = d;
      at = i / 500.0;
    }
  for (double step = 1 / 500.0; step > 1e-9; step *= 0.5)
    for (const double s : {at - step, at + step})
      if (s >= 0 && s <= 1 && (x(s) - p).norm() < best) {
        best = (x(s) - p).norm();
        at = s;
      }
  return best;
}

Noisy noisy(int n, unsigned seed, double sigma, const std::function<Vec3(double)>& x,
            bool closed = false) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> gauss(0, sigma);
  Noisy data;
  for (int i = 0; i < n; ++i) {
    const double a = gauss(engine), b = gauss(engine), c = gauss(engine);
    data.points.push_back(x(static_cast<double>(i) / (closed ? n : n - 1)) + Vec3(a, b, c));
    data.noise += std::pow(distance_to(x, data.points.back()), 2) / n;
  }
  data.noise = std::sqrt(data.noise);
  return data;
}

double error(const HermiteCurve& curve, const std::function<Vec3(double)>& x) {
  double sum = 0;
  for (int i = 0; i <= 100; ++i)
    sum += std::pow(distance_to(
                        x, curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / 100)),
                    2) /
           101;
  return std::sqrt(sum);
}

double error(const std::vector<Vec3>& points, const std::function<Vec3(double)>& x) {
  double sum = 0;
  for (const Vec3& p : points) sum += std::pow(distance_to(x, p), 2);
  return std::sqrt(sum / static_cast<double>(points.size()));
}

CurveCondition condition(CurveCondition::Type type, const Vec3& at,
                         const Vec3& direction = Vec3::UnitZ()) {
  return {"hold", type, at, direction};
}

bool same_bits(const Vec3& a, const Vec3& b) {
  return std::memcmp(a.data(), b.data(), sizeof(Vec3)) == 0;
}

}  // namespace

TEST_CASE("automatic fairing takes more than half of the noise, never adds to it",
          "[fairing][curves]") {
  for (const double sigma : {0.002, 0.007, 0.02}) {
    std::vector<double> ratios;
    for (unsigned seed = 0; seed < 9; ++seed) {
      const Noisy data = noisy(150, seed, sigma, roof);
      const FairCurve fair = fair_points("roof", data.points);
      CHECK(fair.converged);
      CHECK(fair.curve.mesh().corners().empty());
      ratios.push_back(error(fair.curve, roof) / data.noise);
      CHECK(ratios.back() < 0.6);
      CHECK(fairness(fair.curve).extrema <
            fairness(interpolating_spline("roof", data.points)).extrema);
    }
    std::sort(ratios.begin(), ratios.end());
    CHECK(ratios[4] < 0.4);
  }
  const Noisy data = noisy(150, 1, 0.01, loop, true);
  FairOptions options;
  options.closed = true;
  const FairCurve fair = fair_points("loop", data.points, options);
  REQUIRE(fair.curve.closed());
  CHECK(error(fair.curve, loop) < 0.5 * data.noise);
  CHECK(fairness(fair.curve).largest_jump < 0.05 * fairness(fair.curve).largest_curvature);
}

namespace {

// NACA's four-digit section of chord 1 with points clustered at both edges, from the trailing edge
// over the upper side and back.
std::vector<Vec3> airfoil(double camber, double at, double thickness, int side) {
  std::vector<Vec3> upper, lower;
  for (int i = 0; i <= side; ++i) {
    const double x = (1 - std::cos(pi * i / side)) / 2;
    const double y = 5 * thickness *
                     (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x -
                      0.1036 * x * x * x * x);
    const bool front = x < at;
    const double a = front ? at : 1 - at,
                 mean = front ? 2 * at * x - x * x : 1 - 2 * at + 2 * at * x - x * x;
    const double c = camber / (a * a) * mean, slope = 2 * camber / (a * a) * (at - x);
    const Vec3 normal = Vec3(-slope, 1, 0).normalized();
    upper.push_back(Vec3(x, c, 0) + y * normal);
    lower.push_back(Vec3(x, c, 0) - y * normal);
  }
  std::vector<Vec3> points(upper.rbegin(), upper.rend());
  points.insert(points.end(), lower.begin() + 1, lower.end());
  points.back() = points.front();
  return points;
}

}  // namespace

TEST_CASE("automatic fairing leaves exact points where they are: noses, ends, corners",
          "[fairing][curves]") {
  for (const double thickness : {0.06, 0.12, 0.21})
    for (const int side : {30, 70, 200}) {
      const auto points = airfoil(0.02, 0.4, thickness, side);
      const FairCurve fair = fair_points("section", points);
      CHECK(fair.noise < 2e-5);
      CHECK(fair.deviation.max < 1e-4);
      CHECK((fair.curve.evaluate(fair.curve.start()) - points.front()).norm() < 1e-6);
    }
}

TEST_CASE("noses of noisy sections are not flattened, and points move by twice their noise at most",
          "[fairing][curves]") {
  constexpr double sigma = 5e-4;
  std::vector<double> shares;
  for (unsigned seed = 0; seed < 9; ++seed) {
    const auto exact = airfoil(0.03, 0.4, 0.12, 50);
    const HermiteCurve real = interpolating_spline("exact", exact);
    std::mt19937 engine(seed);
    std::normal_distribution<double> gauss(0, sigma);
    std::vector<Vec3> points = exact;
    for (Vec3& p : points) p += Vec3(gauss(engine), gauss(engine), 0);
    const FairCurve fair = fair_points("section", points);
    double before = 0, after = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      before += std::pow(real.closest_point(points[i]).distance, 2);
      after += std::pow(real.closest_point(fair.curve.evaluate(fair.parameters[i])).distance, 2);
    }
    CHECK(fair.deviation.rms < 2 * fair.noise);
    CHECK(std::abs(fair.noise / sigma - 1) < 0.5);
    shares.push_back(std::sqrt(after / before));
  }
  std::sort(shares.begin(), shares.end());
  CHECK(shares[4] < 0.7);
  CHECK(shares.back() < 1);
}

TEST_CASE("curvature of a faired curve has at most twice the extrema of the true one",
          "[fairing][curves]") {
  const auto sine = [](double s) { return Vec3(10 * s, 0.6 * std::sin(8 * pi * s), 0); };
  std::vector<Vec3> exact;
  for (int i = 0; i <= 800; ++i) exact.push_back(sine(i / 800.0));
  const int truth = fairness(interpolating_spline("exact", exact)).extrema;
  REQUIRE(truth == 8);
  for (const double sigma : {0.01, 0.03}) {
    std::vector<int> extrema;
    for (unsigned seed = 0; seed < 9; ++seed) {
      Noisy data = noisy(200, seed, sigma, sine);
      for (Vec3& p : data.points) p.z() = 0;
      extrema.push_back(fairness(fair_points("sine", data.points).curve).extrema);
    }
    std::sort(extrema.begin(), extrema.end());
    CHECK(extrema[4] <= 2 * truth);
  }
}

TEST_CASE("outliers of a noisy curve are ignored, corners and bends are none",
          "[fairing][curves]") {
  constexpr double sigma = 0.004;
  std::vector<double> ratios;
  for (unsigned seed = 0; seed < 9; ++seed) {
    Noisy data = noisy(200, seed, sigma, roof);
    const std::vector<int> off = {17, 60, 62, 101, 140, 183};
    std::mt19937 engine(seed);
    std::normal_distribution<double> gauss;
    for (const int i : off) {
      const Vec3 along = (roof((i + 1) / 199.0) - roof((i - 1) / 199.0)).normalized();
      Vec3 way(gauss(engine), gauss(engine), gauss(engine));
      way -= way.dot(along) * along;
      data.points[static_cast<size_t>(i)] += 12 * sigma * way.normalized();
    }
    FairOptions options;
    const FairCurve fair = fair_points("roof", data.points, options);
    for (const int i : off) CHECK(std::count(fair.outliers.begin(), fair.outliers.end(), i) == 1);
    CHECK(fair.outliers.size() <= off.size() + 1);
    CHECK(fair.parameters.size() == data.points.size());
    ratios.push_back(error(fair.curve, roof) / error(data.points, roof));
    options.reject_outliers = false;
    CHECK(fair_points("roof", data.points, options).outliers.empty());
    options.reject_outliers = true;
    options.corners = off;
    CHECK(fair_points("roof", data.points, options).outliers.size() <= 1);
  }
  std::sort(ratios.begin(), ratios.end());
  CHECK(ratios[4] < 0.5);

  for (const int side : {12, 30, 70})
    CHECK(fair_points("section", airfoil(0.02, 0.4, 0.12, side)).outliers.empty());
  std::vector<Vec3> saw;
  for (int i = 0; i < 60; ++i) saw.emplace_back(i, i % 6 == 3, 0);
  CHECK(fair_points("saw", saw).outliers.empty());
  std::mt19937 engine(1);
  std::normal_distribution<double> gauss(0, 0.02);
  std::vector<Vec3> steps;  // corners in noise
  for (int i = 0; i < 80; ++i)
    steps.emplace_back(std::min(i % 40, 20) + 20 * (i / 40) + gauss(engine),
                       std::max(i % 40 - 20, 0) + 20 * (i / 40) + gauss(engine), 0);
  CHECK(fair_points("steps", steps).outliers.empty());
}

namespace {

// Eight waves per coordinate, with wavelengths of 1/40 to 1/20 of the roof line's length.
std::vector<Vec3> jittered_roof(unsigned seed, double height, const std::vector<int>& axes) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform;
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) points.push_back(roof(i / 199.0));
  for (int wave = 0; wave < 8; ++wave) {
    const double length = 200 / 40.0 * (1 + uniform(engine));
    for (const int axis : axes) {
      const double phase = 2 * pi * uniform(engine);
      for (size_t i = 0; i < points.size(); ++i)
        points[i][axis] += height / 2 * std::sin(2 * pi * static_cast<double>(i) / length + phase);
    }
  }
  return points;
}

double roof_length() { return interpolating_spline("roof", jittered_roof(0, 0, {})).length(); }

}  // namespace

TEST_CASE("correlated noise is removed if its size or wavelength is given", "[fairing][curves]") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const std::vector<Vec3> points = jittered_roof(seed, 0.01, {1, 2});
    const double before = error(points, roof);
    FairOptions options;
    options.smoothing = FairOptions::Smoothing::Wavelength;
    options.wavelength = roof_length() / 10;
    CHECK(error(fair_points("roof", points, options).curve, roof) < 0.5 * before);
    options.smoothing = FairOptions::Smoothing::Noise;
    options.noise = before;
    const FairCurve known = fair_points("roof", points, options);
    CHECK(error(known.curve, roof) < 0.5 * before);
    CHECK(known.deviation.rms < 1.05 * before);
    CHECK(known.deviation.rms > 0.7 * before);
  }
}

TEST_CASE("points that a tremor moves to and fro have no corners where that is stated",
          "[fairing][curves]") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    INFO("seed " << seed);
    const std::vector<Vec3> points = jittered_roof(seed, 0.02, {0, 1, 2});
    const double before = error(points, roof);
    FairOptions options;
    // Without any given parameter, its kinks are taken for corners.
    CHECK(fair_points("roof", points, options).curve.mesh().corners().size() > 5);
    options.smoothing = FairOptions::Smoothing::Wavelength;
    options.wavelength = roof_length() / 6;
    const HermiteCurve smooth = fair_points("roof", points, options).curve;
    CHECK(smooth.mesh().corners().empty());
    CHECK(error(smooth, roof) < 0.5 * before);
    options.smoothing = FairOptions::Smoothing::Noise;
    options.noise = before;
    CHECK(fair_points("roof", points, options).curve.mesh().corners().empty());
  }
}

TEST_CASE("the smoothing spline: its energy is least, its curvature hardly jumps",
          "[fairing][curves]") {
  const Noisy data = noisy(60, 4, 0.01, roof);
  FairOptions options;
  options.smoothing = FairOptions::Smoothing::Wavelength;
  options.wavelength = 1;
  options.max_rounds = 1;
  const FairCurve fair = fair_points("roof", data.points, options);
  const Fairness f = fairness(fair.curve);
  CHECK(f.largest_jump < 1e-3 * f.largest_curvature);
  // Any other curve on the same nodes costs more; points are weighted by their part of the chords.
  std::vector<double> u = {0};
  for (size_t i = 1; i < data.points.size(); ++i)
    u.push_back(u.back() + (data.points[i] - data.points[i - 1]).norm());
  const auto cost = [&](const HermiteCurve& curve) {
    const CurveMesh& mesh = curve.mesh();
    const double a = 1 / (2 * pi), density = 60 / curve.end();
    double springs = 0, change = 0, bending = 0;
    for (size_t i = 0; i < u.size(); ++i)
      springs += (curve.evaluate(u[i] / u.back() * curve.end()) - data.points[i]).squaredNorm();
    for (int s = 0; s < curve.segment_count(); ++s) {
      const double h = mesh.length(s);
      change += h * curve.evaluate({s, 0.5}, 3).squaredNorm();
      for (const auto& [at, weight] : {std::pair(0.0, 1 / 6.0), {0.5, 4 / 6.0}, {1.0, 1 / 6.0}})
        bending += weight * h * curve.evaluate({s, at}, 2).squaredNorm();  // quadratic along it
      if (s > 0)
        change += 2000 / (h + mesh.length(s - 1)) *
                  (curve.evaluate({s, 0}, 2) - curve.evaluate({s - 1, 1}, 2)).squaredNorm();
    }
    const double b = 1 / (1 + std::pow(curve.end() / 2, 2));  // the wavelength is 1
    return springs + density * ((1 - b) * std::pow(a, 6) * change + b * std::pow(a, 4) * bending);
  };
  const double least = cost(fair.curve);
  Random random(8);
  for (int trial = 0; trial < 50; ++trial) {
    Points dofs = fair.curve.dofs();
    for (long d = 0; d < dofs.rows(); ++d) dofs.row(d) += 1e-4 * random.point().transpose();
    CHECK(cost(HermiteCurve(fair.curve.mesh(), dofs)) > least);
    // At the minimum, the gradient of the cost is zero.
    const Points step = 0.01 * (dofs - fair.curve.dofs());
    const double rise = cost(HermiteCurve(fair.curve.mesh(), fair.curve.dofs() + step)) - least,
                 fall = cost(HermiteCurve(fair.curve.mesh(), fair.curve.dofs() - step)) - least;
    CHECK(std::abs(rise - fall) < 0.05 * (rise + fall));
  }
}

TEST_CASE(
    "a wave of the given length keeps half of its height, a longer one more, a shorter one less",
    "[fairing][curves]") {
  const auto kept = [](double wave, double wavelength) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 600; ++i)
      points.emplace_back(i / 20.0, 1e-4 * std::sin(2 * pi * i / 20.0 / wave), 0);
    FairOptions options;
    options.smoothing = FairOptions::Smoothing::Wavelength;
    options.wavelength = wavelength;
    const FairCurve fair = fair_points("wave", points, options);
    double high = 0;
    for (int i = 200; i <= 400; ++i)
      high = std::max(high, std::abs(fair.curve.evaluate(i / 20.0).y()));
    return high / 1e-4;
  };
  CHECK(kept(3, 3) == Approx(0.5).margin(0.01));
  CHECK(kept(6, 3) == Approx(64.0 / 65).margin(0.01));
  CHECK(kept(1.5, 3) == Approx(1.0 / 65).margin(0.01));
}

TEST_CASE("a stated deviation is kept, and used", "[fairing][curves]") {
  const Noisy data = noisy(120, 7, 0.01, roof);
  double before = 1e9;
  for (const double limit : {0.03, 0.01, 0.002}) {
    FairOptions options;
    options.smoothing = FairOptions::Smoothing::Deviation;
    options.deviation = limit;
    const FairCurve fair = fair_points("roof", data.points, options);
    CHECK(fair.deviation.max <= limit);
    CHECK(fair.deviation.max > 0.8 * limit);
    CHECK(fair.wavelength < before);
    before = fair.wavelength;
  }
}

TEST_CASE("a stated deviation far below the noise is kept, without spikes that grow",
          "[fairing][curves]") {
  Random random(11);
  std::vector<Vec3> points;
  for (int i = 0; i < 400; ++i) {
    const double a = 2 * pi * i / 400;
    points.push_back(
        {100 * std::cos(a) + random.between(-3, 3), 100 * std::sin(a) + random.between(-3, 3), 0});
  }
  const PointSequence row("circle", points, 180, {}, true);
  for (const double deviation : {0.02, 0.2, 0.5, 1.0, 2.0}) {
    CAPTURE(deviation);
    FairOptions options;
    options.closed = true;
    options.corner_angle = 180;
    options.smoothing = FairOptions::Smoothing::Deviation;
    options.deviation = deviation;
    options.reject_outliers = false;
    const FairCurve fair = fair_points("circle", points, options);
    CHECK(fair.deviation.max <= deviation);
    for (const Vec3& p : points) CHECK(fair.curve.closest_point(p).distance <= deviation);
    CHECK(HermiteArcLength(fair.curve).total() <= 1.5 * row.length());
  }
}

TEST_CASE("conditions hold exactly after fairing, alone and together, open and closed",
          "[fairing][curves]") {
  using Type = CurveCondition::Type;
  const Noisy data = noisy(100, 11, 0.01, roof);
  const Vec3 far(1e4, -2e4, 3e4);
  for (const Vec3& origin : {Vec3(0, 0, 0), far}) {
    auto points = data.points;
    for (Vec3& p : points) p += origin;
    const Vec3 at = roof(0.3) + origin + Vec3(0, 0.02, 0.02);
    const std::vector<std::vector<CurveCondition>> sets = {
        {condition(Type::Point, at)},
        {condition(Type::Tangent, at, {1, 0.2, 0.1})},
        {condition(Type::Point, at), condition(Type::Tangent, at, {1, 0.2, 0.1})},
        {condition(Type::ZeroEndCurvature, Vec3::Zero())},
        {condition(Type::Plane, origin + Vec3(0, 0.03, 0), {0.01, 1, 0})},
        {condition(Type::Symmetry, origin + Vec3(1.1, 0, 0), {1, 0, 0.02})},
        {condition(Type::Symmetry, origin + Vec3(1.1, 0, 0), {1, 0, 0}),
         condition(Type::Plane, origin + Vec3(0, 0.03, 0), {0, 1, 0}),
         condition(Type::ZeroEndCurvature, Vec3::Zero())}};
    for (const auto& conditions : sets) {
      FairOptions options;
      options.conditions = conditions;
      const FairCurve fair = fair_points("roof", points, options);
      INFO(static_cast<int>(conditions[0].type) << " of " << conditions.size());
      INFO("residual " << 1e12 * fair.max_residual << "e-12");
      CHECK(fair.max_residual < (origin.norm() > 0 ? 1e-10 : 1e-12));
      CHECK(fair.deviation.rms < 0.06);
      if (conditions[0].type == Type::Point) CHECK(fair.curve.closest_point(at).distance < 1e-11);
    }
  }
  FairOptions options;
  options.fix_ends = true;
  const FairCurve held = fair_points("roof", data.points, options);
  CHECK((held.curve.evaluate(0) - data.points.front()).norm() < 1e-15);
  CHECK((held.curve.evaluate(held.curve.end()) - data.points.back()).norm() < 1e-15);

  // A closed loop, symmetric about the plane x = 0 except for noise.
  const Noisy ring = noisy(
      90, 3, 0.01,
      [](double s) { return Vec3(2 * std::cos(2 * pi * s), std::sin(2 * pi * s), 0.1); }, true);
  options.fix_ends = false;
  options.closed = true;
  options.conditions = {condition(Type::Symmetry, Vec3::Zero(), Vec3::UnitX())};
  const FairCurve fair = fair_points("ring", ring.points, options);
  CHECK(fair.max_residual < 1e-12);
  CHECK(fair.deviation.max < 0.05);
  CHECK(std::abs(fair.curve.evaluate(0).x()) < 1e-14);
}

TEST_CASE("a direction is constrained where the final curve is closest to the given point",
          "[fairing][curves]") {
  for (const int n : {20, 50}) {
    std::vector<Vec3> points;
    for (int i = 0; i < n; ++i)
      points.emplace_back(4.0 * i / (n - 1), std::sin(pi * i / (n - 1)), 0);
    FairOptions options;
    options.conditions = {condition(CurveCondition::Type::Tangent, points[6], Vec3::UnitX())};
    const FairCurve fair = fair_points("arch", points, options);
    CHECK(fair.max_residual < 1e-12);
    const Vec3 there = fair.curve.evaluate(fair.curve.closest_point(points[6]).u, 1);
    CHECK(std::abs(there.normalized().y()) < 1e-10);
  }
}

TEST_CASE(
    "corners and conditions that lie close together are no trouble, nor is symmetry of a drawing",
    "[fairing][curves]") {
  using Type = CurveCondition::Type;
  for (const double d : {0.0, 1e-8, 1e-6, 1e-4, 1e-2}) {
    const std::vector<Vec3> corner = {{-1, 0, 0}, {-0.4, 0.8, 0}, {0.4 + d, 0.8, 0}, {1, 0, 0}};
    std::vector<Vec3> points;
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < 12; ++i)
        points.push_back(corner[c] + i / 12.0 * (corner[c + 1] - corner[c]));
    points.push_back(corner[3]);
    INFO(d);
    FairOptions options;
    options.conditions = {condition(Type::Symmetry, Vec3::Zero(), Vec3::UnitX())};
    const FairCurve roof_line = fair_points("roof", points, options);
    CHECK(roof_line.curve.mesh().corners().size() == 2);
    CHECK(roof_line.max_residual < 1e-12);
    CHECK(roof_line.deviation.max < 0.6 * d + 1e-7);
    options.conditions = {condition(Type::Point, corner[1] + Vec3(d, 0, 0))};
    CHECK(fair_points("roof", points, options).max_residual < 1e-12);
  }
}

TEST_CASE("a closed curve under a given wavelength keeps the longer waves", "[fairing][curves]") {
  std::vector<Vec3> circle;
  for (int i = 0; i < 60; ++i)
    circle.emplace_back(std::cos(2 * pi * i / 60), std::sin(2 * pi * i / 60), 0);
  for (const double wavelength : {3.0, 6.0, 10.0}) {
    FairOptions options;
    options.closed = true;
    options.smoothing = FairOptions::Smoothing::Wavelength;
    options.wavelength = wavelength;
    const FairCurve fair = fair_points("circle", circle, options);
    // The circle is one wave around its length 2π.
    const double a = wavelength / (2 * pi);
    const double b = 1 / (1 + std::pow(pi / wavelength, 2));  // of length 2π
    const double kept = 1 / (1 + (1 - b) * std::pow(a, 6) + b * std::pow(a, 4));
    CHECK(fair.curve.length() / (2 * pi) == Approx(kept).epsilon(0.01));
    CHECK(fair.curve.end() == Approx(fair.curve.length()).epsilon(1e-3));
    CHECK(fair.converged);
  }
}

TEST_CASE("corners stay corners", "[fairing][curves]") {
  std::vector<Vec3> points;
  std::mt19937 engine(2);
  std::normal_distribution<double> gauss(0, 0.004);
  const std::vector<Vec3> corner = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < 50; ++i)
      points.push_back(corner[c] + i / 50.0 * (corner[(c + 1) % 4] - corner[c]) +
                       Vec3(gauss(engine), gauss(engine), gauss(engine)));
  FairOptions options;
  options.closed = true;
  const FairCurve fair = fair_points("square", points, options);
  CHECK(fair.curve.mesh().corners().size() == 4);
  for (const Vec3& c : corner) CHECK(fair.curve.closest_point(c).distance < 0.01);
  options.corner_angle = 180;
  CHECK(fair_points("square", points, options).curve.mesh().corners().empty());
}

TEST_CASE("local fairing changes its stretch only, to the last bit",
          "[fairing][curves]") {
  const Noisy data = noisy(200, 5, 0.004, roof);
  FairOptions options;
  options.smoothing = FairOptions::Smoothing::Wavelength;
  options.wavelength = 0.15;
  const HermiteCurve before = fair_points("roof", data.points, options).curve;
  const Vec3 centre = before.evaluate(1.2);
  const HermiteCurve after = fair_brush(before, centre, 0.3, 0.8);
  int changed = 0, same = 0;
  for (int i = 0; i < before.node_count(); ++i) {
    const double u = before.parameters()[i];
    const auto it = std::find(after.parameters().begin(), after.parameters().end(), u);
    if (it == after.parameters().end()) {  // replaced by a node nearby
      ++changed;
      CHECK((before.position(i) - centre).norm() < 0.3);
      continue;
    }
    const int j = static_cast<int>(it - after.parameters().begin());
    const bool unchanged = same_bits(before.position(i), after.position(j)) &&
                           same_bits(before.slope_out(i), after.slope_out(j));
    changed += !unchanged;
    same += unchanged;
    if ((before.position(i) - centre).norm() > 0.3 + 0.02) CHECK(unchanged);
  }
  CHECK(changed > 10);
  CHECK(same > 100);
  // The bits of unchanged segments are the same.
  for (const double u : {0.1, 0.333, 0.7, 1.8, 2.1}) {
    if ((before.evaluate(u) - centre).norm() < 0.32) continue;
    CHECK(same_bits(before.evaluate(u), after.evaluate(u)));
    CHECK(same_bits(before.evaluate(u, 2), after.evaluate(u, 2)));
  }
  // Fairer inside, and close to the original.
  const auto waviness = [&](const HermiteCurve& curve) {
    double sum = 0;
    for (int k = 0; k < 200; ++k) {
      const double u = 1.0 + 0.4 * k / 200;
      sum += curve.evaluate(u, 2).squaredNorm();
    }
    return sum;
  };
  CHECK(waviness(after) < 0.5 * waviness(before));
  for (int k = 0; k <= 100; ++k)
    CHECK(before.closest_point(after.evaluate(after.end() * k / 100)).distance < 0.02);

  // A part by parameters, also across the seam of a closed curve.
  const HermiteCurve middle = fair_interval(before, 0.5, 1, 0.5);
  CHECK(same_bits(middle.evaluate(1.5), before.evaluate(1.5)));
  CHECK((middle.evaluate(0.75) - before.evaluate(0.75)).norm() > 1e-6);
  FairOptions closed = options;
  closed.closed = true;
  const HermiteCurve ring =
      fair_points("loop", noisy(150, 6, 0.01, loop, true).points, closed).curve;
  const double end = ring.end();
  const HermiteCurve seam = fair_interval(ring, 0.95 * end, 0.05 * end, 1);
  REQUIRE(seam.closed());
  CHECK((seam.evaluate(0) - ring.evaluate(0)).norm() > 1e-6);
  CHECK(same_bits(seam.evaluate(0.5 * end), ring.evaluate(0.5 * end)));
  CHECK((seam.slope_in(0) - seam.slope_out(0)).norm() == 0);
  // However long the segments: a cubic has the least variation of its second derivative already.
  const HermiteCurve beam({0, 10}, (Points(2, 3) << 0, 0, 0, 10, 0, 0).finished(),
                          (Points(2, 3) << 1, 1, 0, 1, 1, 0).finished());
  CHECK((fair_interval(beam, 4.0, 4.3, 100).evaluate(4.15) - beam.evaluate(4.15)).norm() < 1e-9);
  CHECK((fair_brush(beam, beam.evaluate(7.77), 0.1, 100).evaluate(7.77) - beam.evaluate(7.77))
            .norm() < 1e-9);
  CHECK_THAT(error_message([&] { fair_interval(beam, 20, 30, 1); }), Contains("from 20 to 30"));
  // Less bending by a dense minimisation: no node can improve it.
  const HermiteCurve corner =
      interpolating_spline("corner", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}});
  REQUIRE(corner.mesh().corners().size() == 1);
  CHECK(fair_brush(corner, {2, 0, 0}, 1, 1).mesh().corners().size() == 1);
  // The shape does not depend on the unit of the parameter.
  std::vector<double> slower = before.parameters();
  for (double& u : slower) u *= 3;
  Points dofs = before.dofs();
  for (int i = 0; i < before.node_count(); ++i) dofs.row(before.mesh().slope_out(i)) /= 3;
  const HermiteCurve tripled = fair_interval(HermiteCurve(CurveMesh(slower), dofs), 1.5, 3, 0.5);
  for (int k = 0; k <= 50; ++k) {
    const double u = 0.5 + 0.5 * k / 50;
    CHECK((tripled.evaluate(3 * u) - middle.evaluate(u)).norm() < 1e-9);
  }
  // Extreme settings: still a curve.
  CHECK(fair_brush(ring, Vec3::Zero(), 10, 1).closed());
  CHECK(fair_brush(before, centre, 10, 0.5).length() == Approx(before.length()).epsilon(0.05));
}

TEST_CASE("points that cannot be faired are refused by name", "[fairing][curves]") {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {3, 1, 1}};
  FairOptions options;
  const auto fair = [&] { fair_points("rib", points, options); };
  for (const double wrong : {0.0, -1.0, double(NAN)}) {
    options.smoothing = FairOptions::Smoothing::Deviation;
    options.deviation = wrong;
    CHECK_THAT(error_message(fair),
               Contains("'rib'") && Contains("deviation") && Contains("above 0"));
    options.smoothing = FairOptions::Smoothing::Wavelength;
    options.wavelength = wrong;
    CHECK_THAT(error_message(fair),
               Contains("'rib'") && Contains("wavelength") && Contains("above 0"));
  }
  options = {};
  options.alpha = -1;
  CHECK_THAT(error_message(fair), Contains("alpha"));
  options = {};
  options.closed = true;
  options.conditions = {condition(CurveCondition::Type::ZeroEndCurvature, Vec3::Zero())};
  CHECK_THAT(error_message(fair), Contains("'hold'") && Contains("open"));
  options.closed = false;
  options.conditions = {condition(CurveCondition::Type::Plane, Vec3::Zero(), Vec3::Zero())};
  CHECK_THAT(error_message(fair), Contains("'hold'"));
  options.conditions = {{"left", CurveCondition::Type::Plane, {0, 0, 0}, {0, 0, 1}},
                        {"right", CurveCondition::Type::Plane, {0, 0, 1}, {0, 0, 1}}};
  CHECK_THROWS_AS(fair(), ConflictError);
  CHECK_THAT(error_message([&] {
               fair_points("rib", {{0, 0, 0}});
             }),
             Contains("'rib' has 1 point"));
  const HermiteCurve curve = interpolating_spline("rib", points);
  CHECK_THAT(error_message([&] {
               fair_brush(curve, {0, 9, 0}, 1, 1);
             }),
             Contains("lies outside of the brush"));
  CHECK_THAT(error_message([&] { fair_brush(curve, {0, 0, 0}, -1, 1); }), Contains("radius"));
  CHECK_THAT(error_message([&] { fair_brush(curve, {0, 0, 0}, 1, 0); }), Contains("wavelength"));
  CHECK_THAT(error_message([&] { fair_interval(curve, 2, 1, 1); }), Contains("segment"));
}

TEST_CASE("odd point lists are faired: two points, a line, there and back, repeats, a crowd",
          "[fairing][curves]") {
  const auto fair = [](const std::vector<Vec3>& points) { return fair_points("odd", points); };
  CHECK(fair({{0, 0, 0}, {1, 1, 1}}).curve.length() == Approx(std::sqrt(3)));
  CHECK(fair({{0, 0, 0}, {1, 1, 1}, {1, 1, 1}, {2, 0, 0}}).parameters.size() == 4);
  std::vector<Vec3> line, back;
  for (int i = 0; i < 40; ++i) line.emplace_back(i, 2 * i, 0);
  CHECK(fair(line).deviation.max < 1e-8);
  back = line;
  for (int i = 39; i-- > 0;) back.push_back(line[i]);
  CHECK(fair(back).deviation.max < 0.1);
  std::vector<Vec3> eight;
  for (int i = 0; i < 100; ++i)
    eight.emplace_back(std::sin(2 * pi * i / 99), std::sin(4 * pi * i / 99), 0);
  CHECK(fair(eight).deviation.max < 0.01);
  const Noisy crowd = noisy(100000, 9, 0.01, roof);
  const FairCurve many = fair(crowd.points);
  CHECK(many.curve.node_count() <= 2001);
  CHECK(error(many.curve, roof) < 0.1 * crowd.noise);
}

TEST_CASE("every stroke of the hand-drawn sketches goes through fit and fair",
          "[fairing][curves][data]") {
  const auto folder = optional_data("sketch-cassie/curves");
  if (folder.empty()) {
    WARN("skipped: no sketches on this machine");
    return;
  }
  int strokes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".curves") continue;
    std::ifstream in(entry.path());
    std::string word;
    for (int n = 0; in >> word >> n;) {
      std::vector<Vec3> points(n);
      for (Vec3& p : points) in >> p.x() >> p.y() >> p.z();
      INFO(entry.path().filename() << ", stroke " << strokes);
      FitOptions options;
      options.tolerance = 1e-3;
      const CurveFit fit = fit_points("stroke", points, options);
      CHECK(fit.deviation.max <= options.tolerance);
      const FairCurve fair = fair_points("stroke", points);
      Vec3 low = points[0], high = points[0];
      for (const Vec3& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
      const double size = (high - low).norm();
      CHECK(fair.deviation.rms <= 0.06 * size);  // 2.5 %, plus the effect of moving parameters
      CHECK(fair.curve.length() <= 1.05 * interpolating_spline("stroke", points).length());
      ++strokes;
    }
  }
  CHECK(strokes == 1431);
}
