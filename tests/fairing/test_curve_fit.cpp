// The curve fit: few segments, within the tolerance both ways; exact where the input is cubic.
#include <cmath>
#include <fstream>
#include <numbers>

#include "batten/fairing/curve_fit.h"

#include "batten/core/errors.h"
#include "batten/tests/catch.h"
#include "batten/tests/reference.h"
#include "batten/tests/refusal.h"
#include "batten/tests/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi;

std::vector<Vec3> points_of(int n, const std::function<Vec3(double)>& x, bool closed = false) {
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) points.push_back(x(static_cast<double>(i) / (closed ? n : n - 1)));
  return points;
}

Vec3 helix(double s) { return {std::cos(5 * s), std::sin(5 * s), 2 * s}; }

FitOptions within(double tolerance) {
  FitOptions options;
  options.tolerance = tolerance;
  return options;
}

// Largest distance of points from a curve, by its own closest points.
double farthest(const HermiteCurve& curve, const std::vector<Vec3>& points) {
  double worst = 0;
  for (const Vec3& p : points) worst = std::max(worst, curve.closest_point(p).distance);
  return worst;
}

// Largest jump of the tangent direction over all nodes but corners, radians.
double largest_kink(const HermiteCurve& curve) {
  double worst = 0;
  const int n = curve.segment_count();
  for (int s = curve.closed() ? 0 : 1; s < n; ++s) {
    if (curve.mesh().is_corner(s)) continue;
    const Vec3 a = curve.evaluate({s == 0 ? n - 1 : s - 1, 1}, 1), b = curve.evaluate({s, 0}, 1);
    worst = std::max(worst, (a - b).norm() / b.norm());
  }
  return worst;
}

std::shared_ptr<const InputCurve> ellipse() {
  return curve_from_formula(0, 2 * pi, [](double t, int order) -> Vec3 {
    const double c = std::cos(t + order * pi / 2), s = std::sin(t + order * pi / 2);
    return {2 * c, s, 0};
  });
}

}  // namespace

TEST_CASE("a fit keeps its tolerance both ways, with fewer segments than points, and is C1") {
  const auto points = points_of(200, helix);
  int before = 0;
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const CurveFit fit = fit_points("helix", points, within(tolerance));
    CHECK(fit.deviation.max <= tolerance);
    CHECK(fit.deviation.between <= tolerance);
    CHECK(farthest(fit.curve, points) <= fit.deviation.max * (1 + 1e-9));
    for (int i = 0; i < 200; ++i)  // between the points too: the helix itself
      CHECK(fit.curve.closest_point(helix((i + 0.5) / 200)).distance <= tolerance + 1e-6);
    CHECK(largest_kink(fit.curve) < 1e-12);
    CHECK((fit.curve.position(0) - points.front()).norm() < 1e-15);
    CHECK((fit.curve.position(fit.curve.node_count() - 1) - points.back()).norm() < 1e-15);
    // Fourth order at least: a hundredth of the tolerance, no more than 3.2 times the segments.
    const int segments = fit.curve.segment_count();
    INFO(tolerance << ": " << segments);
    if (before > 0) CHECK(segments <= 3.3 * before);
    CHECK(segments <= (tolerance > 5e-3 ? 4 : tolerance > 5e-5 ? 11 : 36));
    before = segments;
    REQUIRE(fit.parameters.size() == points.size());
    for (size_t i = 1; i < points.size(); ++i) CHECK(fit.parameters[i] > fit.parameters[i - 1]);
  }
}

TEST_CASE("a fit does not see where the points are, nor in which unit") {
  const auto points = points_of(60, helix);
  const CurveFit fit = fit_points("line", points, within(1e-3));
  auto moved = points;
  const Mat3 turn = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& p : moved) p = 1000 * (turn * p);
  const CurveFit other = fit_points("line", moved, within(1));
  REQUIRE(other.curve.segment_count() == fit.curve.segment_count());
  for (int i = 0; i < fit.curve.node_count(); ++i)
    CHECK((other.curve.position(i) - 1000 * (turn * fit.curve.position(i))).norm() < 1e-6);
}

TEST_CASE("a closed fit is C1 across its seam") {
  const auto points = points_of(
      80,
      [](double s) {
        return Vec3(2 * std::cos(2 * pi * s), std::sin(2 * pi * s), 0.2 * std::sin(4 * pi * s));
      },
      true);
  auto repeated = points;
  repeated.push_back(points.front());
  FitOptions options = within(1e-3);
  const CurveFit fit = fit_points("loop", repeated, options);
  REQUIRE(fit.curve.closed());
  CHECK(largest_kink(fit.curve) < 1e-12);
  CHECK(fit.deviation.max <= 1e-3);
  CHECK(fit.deviation.between <= 1e-3);
  CHECK(fit.curve.segment_count() <= 12);
  options.closed = true;  // said, without repeating the point
  CHECK(fit_points("loop", points, options).curve.segment_count() == fit.curve.segment_count());
  options.closed = false;
  CHECK_FALSE(fit_points("loop", repeated, options).curve.closed());
}

TEST_CASE("corners are found, kept exactly, and no more than there are") {
  // A house: five corners, 20 points a side.
  const std::vector<Vec3> corner = {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2, 5, 0}, {0, 3, 0}};
  std::vector<Vec3> points;
  for (int c = 0; c < 5; ++c)
    for (int i = 0; i < 20; ++i)
      points.push_back(corner[c] + i / 20.0 * (corner[(c + 1) % 5] - corner[c]));
  FitOptions options = within(1e-6);
  options.closed = true;
  options.corner_angle = 40;
  const CurveFit fit = fit_points("house", points, options);
  CHECK(fit.curve.mesh().corners().size() == 5);
  CHECK(fit.curve.segment_count() == 5);
  for (const Vec3& c : corner) CHECK(fit.curve.closest_point(c).distance < 1e-14);
  // Noise of a tenth of the spacing makes no corners, and hides none.
  Random random(3);
  for (Vec3& p : points) p += 0.02 * random.point();
  CHECK(find_corners(points, true, 40) == std::vector<int>{0, 20, 40, 60, 80});
  auto smooth = points_of(150, helix);
  for (const double noise : {0.0, 0.01, 0.05, 0.2}) {
    for (Vec3& p : smooth) p += noise * random.point();
    CHECK(find_corners(smooth, false, 50).empty());
  }
  // Given corners count instead.
  options.corners = {{0, 40}};
  CHECK(fit_points("house", points, within(0.1)).curve.mesh().corners().size() <= 5);
  options.tolerance = 0.05;
  const CurveFit two = fit_points("house", points, options);
  CHECK(two.curve.mesh().corners().size() == 2);
  CHECK(two.curve.closest_point(points[40]).distance < 1e-14);
}

TEST_CASE("a cubic input is converted exactly, whatever the speeds of its pieces") {
  // Two Bézier pieces that meet with one direction and different speeds, then a corner.
  const auto first = bezier_curve({0, 0, 0}, {1, 0, 1}, {2, 1, 1}, {3, 1, 0});
  const HermiteCurve one = *exact_curve(*first, 50);
  REQUIRE(one.segment_count() == 1);
  CHECK(one.end() == Approx(one.length()).epsilon(1e-9));
  for (int k = 0; k <= 20; ++k)
    CHECK((one.evaluate(one.end() * k / 20.0) - first->evaluate(k / 20.0)).norm() < 2e-15);

  const auto house =
      curve_through_points("house", {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2, 5, 0}}, 30);
  const HermiteCurve cornered = *exact_curve(*house, 30);
  CHECK(cornered.mesh().corners() == std::vector<int>{1, 2});
  for (int k = 0; k <= 50; ++k) {
    const double t = house->start() + (house->end() - house->start()) * k / 50;
    CHECK(cornered.closest_point(house->evaluate(t)).distance < 1e-14);
  }
  CHECK_FALSE(exact_curve(*ellipse(), 50));
  // A Hermite curve comes back as it is, closed and with uneven parameters.
  Random random(5);
  Points dofs(10, 3);
  for (int i = 0; i < 5; ++i) {
    dofs.row(2 * i) = Vec3(std::cos(2 * pi * i / 5), std::sin(2 * pi * i / 5), 0.1 * random());
    dofs.row(2 * i + 1) = Vec3(-std::sin(2 * pi * i / 5), std::cos(2 * pi * i / 5), 0.1);
  }
  const HermiteCurve loop(CurveMesh({0, 1, 2.5, 3.4, 5, 6.1}, true), dofs);
  const HermiteCurve again = fit_curve("loop", curve_from_hermite(loop), within(1e-3));
  REQUIRE(again.closed());
  REQUIRE(again.segment_count() == 5);
  for (int k = 0; k <= 60; ++k)
    CHECK((again.evaluate(again.end() * k / 60) - loop.evaluate(6.1 * k / 60)).norm() < 1e-13);
}

TEST_CASE("an input that is not cubic is fitted within the tolerance, both ways") {
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const HermiteCurve fit = fit_curve("ellipse", ellipse(), within(tolerance));
    REQUIRE(fit.closed());
    double there = 0, back = 0;
    for (int k = 0; k < 777; ++k) {
      const double t = 2 * pi * k / 777;
      there = std::max(there, fit.closest_point(ellipse()->evaluate(t)).distance);
      const Vec3 p = fit.evaluate(fit.end() * k / 777);
      back = std::max(back, std::abs(std::sqrt(p.x() * p.x() / 4 + p.y() * p.y()) - 1));
    }
    CHECK(there <= tolerance);
    CHECK(back <= 2 * tolerance);
    CHECK(largest_kink(fit) < 1e-12);
    INFO(fit.segment_count());
    CHECK(fit.segment_count() <= (tolerance > 5e-3 ? 7 : tolerance > 5e-5 ? 19 : 81));
  }
  FitOptions even = within(1e-4);
  even.even = true;
  const HermiteCurve fit = fit_curve("ellipse", ellipse(), even);
  for (int k = 0; k < 100; ++k)
    CHECK(fit.evaluate(fit.end() * k / 100, 1).norm() == Approx(1).margin(0.01));
  even.halved = true;
  even.closed = false;
  const HermiteCurve halves = fit_curve("ellipse", ellipse(), even);
  for (const double u : halves.parameters()) {
    const double steps = u / halves.end() * 4096;
    CHECK(steps == Approx(std::round(steps)).margin(1e-9));
  }
}

TEST_CASE("what cannot be fitted is refused by name, what is odd is fitted") {
  const FitOptions options = within(0.01);
  const auto fit = [&](const std::vector<Vec3>& points) {
    return fit_points("rim", points, options);
  };
  CHECK_THAT(refusal([&] { fit({}); }), Contains("'rim' has 0 points"));
  CHECK_THAT(refusal([&] { fit({{1, 2, 3}}); }), Contains("'rim' has 1 point:"));
  CHECK_THAT(refusal([&] { fit({{1, 2, 3}, {1, 2, 3}}); }), Contains("zero length"));
  CHECK_THAT(refusal([&] {
               fit({{0, 0, 0}, {1, NAN, 0}});
             }),
             Contains("point 2") && Contains("finite"));
  CHECK_THAT(refusal([&] { fit({{0, 0, 0}, {1e300, 0, 0}}); }), Contains("point 2"));
  for (const double tolerance : {0.0, -1.0, double(NAN), double(INFINITY)})
    CHECK_THAT(refusal([&] {
                 fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, within(tolerance));
               }),
               Contains("tolerance") && Contains("above 0"));
  FitOptions corner = options;
  corner.corners = {{7}};
  CHECK_THAT(refusal([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("corner at point 8 of 2"));
  corner.corners.reset();
  corner.corner_angle = 0;
  CHECK_THAT(refusal([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("corner angle"));
  corner.corner_angle = 180;
  corner.closed = true;
  CHECK_THAT(refusal([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("three or more"));

  // Two points, repeated points, all on a line, there and back, a crossing.
  CHECK(fit({{0, 0, 0}, {1, 1, 1}}).curve.segment_count() == 1);
  CHECK(fit({{0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}}).parameters.size() == 4);
  const CurveFit straight = fit(points_of(50, [](double s) { return Vec3(s, 2 * s, 3 * s); }));
  CHECK(straight.curve.segment_count() == 1);
  CHECK(straight.deviation.max < 1e-7);
  auto doubled = points_of(30, [](double s) { return Vec3(s, 0, 0); });
  for (int i = 29; i-- > 0;) doubled.push_back(doubled[i]);
  const CurveFit back = fit(doubled);
  CHECK(back.deviation.max <= 0.01);
  CHECK(back.curve.mesh().corners().size() == 2);  // closed: where it turns, and where it ends
  CHECK(back.curve.length() == Approx(2).epsilon(0.02));
  const auto eight = points_of(
      60, [](double s) { return Vec3(std::sin(2 * pi * s), std::sin(4 * pi * s), 0); }, true);
  corner = options;
  corner.closed = true;
  const CurveFit crossing = fit_points("eight", eight, corner);
  CHECK(crossing.deviation.max <= 0.01);
  CHECK(crossing.curve.length() == Approx(9.43).epsilon(0.01));  // passes the crossing twice
  // A smooth curve cannot turn back: the points are still kept.
  corner.closed = false;
  corner.corner_angle = 180;
  CHECK(fit_points("back", doubled, corner).deviation.max <= 0.01);
}

TEST_CASE("fuzz: whatever the points, the fit keeps its tolerance at them") {
  Random random(17);
  for (int trial = 0; trial < 400; ++trial) {
    const int n = 2 + static_cast<int>(random.between(0, 40));
    std::vector<Vec3> points = {random.point()};
    const double drift = random.between(0, 2), scale = std::pow(10, random.between(-6, 6));
    Vec3 direction = random.point();
    for (int i = 1; i < n; ++i) {
      direction += 0.5 * random.point();
      points.push_back(points.back() + 0.1 * drift * direction + 0.02 * random.point());
      if (random() > 0.9) points.push_back(points.back());
      if (random() > 0.97) points.push_back(points.front());
    }
    for (Vec3& p : points) p *= scale;
    FitOptions options = within(scale * std::pow(10, random.between(-5, -1)));
    options.corner_angle = random() > 0 ? 180 : 40;
    options.closed = n > 3 && random() > 0.5;
    CurveFit fit;
    const std::string refused = refusal([&] { fit = fit_points("fuzz", points, options); });
    INFO(trial << ", " << points.size() << " points, tolerance " << options.tolerance << " "
               << refused);
    if (!refused.empty()) {
      CHECK_THAT(refused, Contains("three or more") || Contains("zero length"));
      continue;
    }
    CHECK(fit.deviation.max <= options.tolerance);
    CHECK(farthest(fit.curve, points) <= options.tolerance * (1 + 1e-9));
    CHECK(fit.deviation.between < 0.5 * scale);  // no loops, however wild the points
    CHECK(fit.curve.segment_count() <= 2 * static_cast<int>(points.size()) + 4);
    CHECK(largest_kink(fit.curve) < 1e-9);
  }
}

TEST_CASE("a hundred thousand noisy points are fitted in few segments") {
  Random random(23);
  auto points = points_of(100000, helix);
  for (Vec3& p : points) p += 0.001 * random.point();
  const CurveFit fit = fit_points("long", points, within(0.005));
  CHECK(fit.deviation.max <= 0.005);
  CHECK(fit.curve.segment_count() <= 8);
}
