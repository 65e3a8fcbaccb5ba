// SPDX-License-Identifier: MPL-2.0
// Curve fit: few segments, within the tolerance in both directions; exact if the input is cubic.
#include <cmath>
#include <fstream>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/corners/corners.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/curve_fit_problem.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

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

// Largest distance of points from a curve, by its own closest-point search.
double farthest(const HermiteCurve& curve, const std::vector<Vec3>& points) {
  double worst = 0;
  for (const Vec3& p : points) worst = std::max(worst, curve.closest_point(p).distance);
  return worst;
}

// Largest jump of the tangent direction over all nodes except corners, radians.
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

TEST_CASE("a fit keeps its tolerance both ways, with fewer segments than points, and is C1",
          "[fairing][curve_fit]") {
  const auto points = points_of(200, helix);
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    const CurveFit fit = fit_points("helix", points, within(tolerance));
    CHECK(fit.deviation.max <= tolerance);
    CHECK(fit.deviation.between <= tolerance);
    CHECK(farthest(fit.curve, points) <= fit.deviation.max * (1 + 1e-9));
    for (int i = 0; i < 200; ++i)  // between the points, too: distance from the helix itself
      CHECK(fit.curve.closest_point(helix((i + 0.5) / 200)).distance <= tolerance + 1e-6);
    CHECK(largest_kink(fit.curve) < 1e-12);
    CHECK((fit.curve.position(0) - points.front()).norm() < 1e-15);
    CHECK((fit.curve.position(fit.curve.node_count() - 1) - points.back()).norm() < 1e-15);
    // Fourth order: 1/100 of the tolerance needs 3.2 times as many segments.
    const int segments = fit.curve.segment_count();
    INFO(tolerance << ": " << segments);
    CHECK(segments <= (tolerance > 5e-3 ? 4 : tolerance > 5e-5 ? 11 : 36));
    REQUIRE(fit.parameters.size() == points.size());
    for (size_t i = 1; i < points.size(); ++i) CHECK(fit.parameters[i] > fit.parameters[i - 1]);
  }
}

TEST_CASE("a fit does not see where the points are, nor in which unit", "[fairing][curve_fit]") {
  const auto points = points_of(60, helix);
  const CurveFit fit = fit_points("line", points, within(1e-3));
  auto moved = points;
  const Mat3 rotation = Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (Vec3& p : moved) p = 1000 * (rotation * p);
  const CurveFit other = fit_points("line", moved, within(1));
  REQUIRE(other.curve.segment_count() == fit.curve.segment_count());
  for (int i = 0; i < fit.curve.node_count(); ++i)
    CHECK((other.curve.position(i) - 1000 * (rotation * fit.curve.position(i))).norm() < 1e-6);
}

TEST_CASE("a closed fit is C1 across its seam", "[fairing][curve_fit]") {
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
  options.closed = true;  // explicitly closed, without repeating the point
  CHECK(fit_points("loop", points, options).curve.segment_count() == fit.curve.segment_count());
  options.closed = false;
  CHECK_FALSE(fit_points("loop", repeated, options).curve.closed());
}

TEST_CASE("corners are found, kept exactly, and no more than there are", "[fairing][curve_fit]") {
  // A house: five corners, 20 points per side.
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
  // Noise of a tenth of the spacing neither creates corners nor hides them.
  Random random(3);
  for (Vec3& p : points) p += 0.02 * random.point();
  CHECK(find_corners(points, true, 40) == std::vector<int>{0, 20, 40, 60, 80});
  auto smooth = points_of(150, helix);
  for (const double noise : {0.0, 0.01, 0.05, 0.2}) {
    for (Vec3& p : smooth) p += noise * random.point();
    CHECK(find_corners(smooth, false, 50).empty());
  }
  // Given corners are used instead.
  options.corners = {{0, 40}};
  CHECK(fit_points("house", points, within(0.1)).curve.mesh().corners().size() <= 5);
  options.tolerance = 0.05;
  const CurveFit two = fit_points("house", points, options);
  CHECK(two.curve.mesh().corners().size() == 2);
  CHECK(two.curve.closest_point(points[40]).distance < 1e-14);
}

TEST_CASE("a cubic input is converted exactly, whatever the speeds of its pieces",
          "[fairing][curve_fit]") {
  // Two Bézier segments with the same direction and different speeds at their junction, then a
  // corner.
  const auto first = bezier_curve({0, 0, 0}, {1, 0, 1}, {2, 1, 1}, {3, 1, 0});
  const HermiteCurve one = *exact_curve(*first, 50);
  REQUIRE(one.segment_count() == 1);
  CHECK(one.end() == Approx(one.length()).epsilon(1e-9));
  for (int k = 0; k <= 20; ++k)
    CHECK((one.evaluate(one.end() * k / 20.0) - first->evaluate(k / 20.0)).norm() < 2e-15);

  const auto house = curve_through_points("house", {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2, 5, 0}}, 30,
                                          std::vector<int>{1, 2});
  const HermiteCurve cornered = *exact_curve(*house, 30);
  CHECK(cornered.mesh().corners() == std::vector<int>{1, 2});
  for (int k = 0; k <= 50; ++k) {
    const double t = house->start() + (house->end() - house->start()) * k / 50;
    CHECK(cornered.closest_point(house->evaluate(t)).distance < 1e-14);
  }
  CHECK_FALSE(exact_curve(*ellipse(), 50));
  // A Hermite curve is reproduced, also closed and with uneven parameters.
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

TEST_CASE("an input that is not cubic is fitted within the tolerance, both ways",
          "[fairing][curve_fit]") {
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
    CHECK(fit.segment_count() <= (tolerance > 5e-3 ? 7 : tolerance > 5e-5 ? 22 : 81));
  }
  FitOptions fixed_parameters = within(1e-4);
  fixed_parameters.fixed_parameters = true;
  const HermiteCurve fit = fit_curve("ellipse", ellipse(), fixed_parameters);
  for (int k = 0; k < 100; ++k)
    CHECK(fit.evaluate(fit.end() * k / 100, 1).norm() == Approx(1).margin(0.01));
  fixed_parameters.bisection_only = true;
  fixed_parameters.closed = false;
  const HermiteCurve halves = fit_curve("ellipse", ellipse(), fixed_parameters);
  for (const double u : halves.parameters()) {
    const double steps = u / halves.end() * 4096;
    CHECK(steps == Approx(std::round(steps)).margin(1e-9));
  }
}

TEST_CASE("points that cannot be fitted are refused by name, unusual ones are fitted",
          "[fairing][curve_fit]") {
  const FitOptions options = within(0.01);
  const auto fit = [&](const std::vector<Vec3>& points) {
    return fit_points("rim", points, options);
  };
  CHECK_THAT(error_message([&] { fit({}); }), Contains("'rim' has 0 points"));
  CHECK_THAT(error_message([&] { fit({{1, 2, 3}}); }), Contains("'rim' has 1 point,"));
  CHECK_THAT(error_message([&] { fit({{1, 2, 3}, {1, 2, 3}}); }), Contains("zero length"));
  CHECK_THAT(error_message([&] {
               fit({{0, 0, 0}, {1, NAN, 0}});
             }),
             Contains("point 2") && Contains("finite"));
  CHECK_THAT(error_message([&] { fit({{0, 0, 0}, {1e300, 0, 0}}); }), Contains("point 2"));
  for (const double tolerance : {0.0, -1.0, double(NAN), double(INFINITY)})
    CHECK_THAT(error_message([&] {
                 fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, within(tolerance));
               }),
               Contains("tolerance") && Contains("above 0"));
  FitOptions corner = options;
  corner.corners = {{7}};
  CHECK_THAT(error_message([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("corner at point 8, expected 1 to 2"));
  corner.corners.reset();
  corner.corner_angle = 0;
  CHECK_THAT(error_message([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("corner angle"));
  corner.corner_angle = 180;
  corner.closed = true;
  CHECK_THAT(error_message([&] {
               fit_points("rim", {{0, 0, 0}, {1, 0, 0}}, corner);
             }),
             Contains("three or more"));

  // Two points, repeated points, collinear points, back and forth, a self-intersection.
  CHECK(fit({{0, 0, 0}, {1, 1, 1}}).curve.segment_count() == 1);
  CHECK(fit({{0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}}).parameters.size() == 4);
  const CurveFit straight = fit(points_of(50, [](double s) { return Vec3(s, 2 * s, 3 * s); }));
  CHECK(straight.curve.segment_count() == 1);
  CHECK(straight.deviation.max < 1e-7);
  auto doubled = points_of(30, [](double s) { return Vec3(s, 0, 0); });
  for (int i = 29; i-- > 0;) doubled.push_back(doubled[i]);
  const CurveFit back = fit(doubled);
  CHECK(back.deviation.max <= 0.01);
  CHECK(back.curve.mesh().corners().size() == 2);  // closed: at the turning point and at the end
  CHECK(back.curve.length() == Approx(2).epsilon(0.02));
  const auto eight = points_of(
      60, [](double s) { return Vec3(std::sin(2 * pi * s), std::sin(4 * pi * s), 0); }, true);
  corner = options;
  corner.closed = true;
  const CurveFit crossing = fit_points("eight", eight, corner);
  CHECK(crossing.deviation.max <= 0.01);
  CHECK(crossing.curve.length() == Approx(9.43).epsilon(0.01));  // passes it twice
  // A smooth curve cannot reverse its direction: the points are still within the tolerance.
  corner.closed = false;
  corner.corner_angle = 180;
  CHECK(fit_points("back", doubled, corner).deviation.max <= 0.01);
}

TEST_CASE("fuzz: whatever the points, the fit keeps its tolerance at them",
          "[fairing][curve_fit]") {
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
    const std::string refused = error_message([&] { fit = fit_points("fuzz", points, options); });
    INFO(trial << ", " << points.size() << " points, tolerance " << options.tolerance << " "
               << refused);
    if (!refused.empty()) {
      CHECK_THAT(refused, Contains("three or more") || Contains("zero length"));
      continue;
    }
    CHECK(fit.deviation.max <= options.tolerance);
    CHECK(farthest(fit.curve, points) <= options.tolerance * (1 + 1e-9));
    CHECK(fit.deviation.between < 0.5 * scale);  // no loops, even for irregular points
    CHECK(fit.curve.segment_count() <= 2 * static_cast<int>(points.size()) + 4);
    CHECK(largest_kink(fit.curve) < 1e-9);
  }
}

TEST_CASE("halved fits end, within the tolerance or refused", "[fairing][curve_fit]") {
  FitOptions options = within(1e-4);
  options.fixed_parameters = options.bisection_only = true;
  options.corner_angle = 180;
  const auto kept = [&](const std::string& refused, double deviation) {
    INFO(refused << " " << deviation);
    if (refused.empty())
      CHECK(deviation <= options.tolerance);
    else
      CHECK_THAT(refused, Contains("add a corner, or increase the tolerance"));
  };
  Random random(4);
  auto noisy = points_of(33, helix);
  for (Vec3& p : noisy) p += 0.01 * random.point();
  for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-9}) {
    options.tolerance = tolerance;
    for (const double degrees : {2.0, 6.0, 19.0}) {
      const auto kink = curve_through_points(
          "kink", {{0, 0, 0}, {0.9, 0, 0}, {2, 1.1 * std::tan(degrees * pi / 180), 0}}, 1);
      HermiteCurve fit;
      const std::string refused = error_message([&] { fit = fit_curve("kink", kink, options); });
      kept(refused, refused.empty() ? fit.closest_point({0.9, 0, 0}).distance : 0);
    }
    CurveFit fit;
    const std::string refused = error_message([&] { fit = fit_points("noisy", noisy, options); });
    kept(refused, fit.deviation.max);
  }
}

TEST_CASE("points that all but repeat their neighbour are no corners", "[fairing][curve_fit]") {
  for (const double d : {1e-12, 1e-11, 1e-9, 1e-7, 1e-5, 1e-4}) {
    std::vector<Vec3> arc;
    for (int i = 0; i < 60; ++i) {
      arc.emplace_back(std::cos(0.05 * i), std::sin(0.05 * i), 0);
      if (i == 20) arc.push_back((1 - d) * arc.back());
    }
    INFO(d);
    const CurveFit fit = fit_points("arc", arc, within(1e-3));
    CHECK(fit.curve.mesh().corners().empty());
    CHECK(fit.deviation.max <= 1e-3);
    CHECK(fit.parameters.size() == arc.size());
  }
  // Corners are also found in short lists.
  CHECK(find_corners({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}}, false, 50) ==
        std::vector<int>{2});
}

TEST_CASE("a curve does not race through the hooks of a stroke, nor stray between its points",
          "[fairing][curve_fit]") {
  // Hand-drawn; hooks at both ends, where the pen was set down and lifted.
  const std::vector<Vec3> stroke = {
      {0.1019, 0.9136, 0.4299}, {0.0987, 0.9116, 0.4319}, {0.1155, 0.9114, 0.4798},
      {0.1246, 0.9125, 0.5308}, {0.1278, 0.9135, 0.5723}, {0.1262, 0.9156, 0.6244},
      {0.1211, 0.9180, 0.6539}, {0.1088, 0.9193, 0.6865}, {0.1004, 0.9174, 0.6997},
      {0.0805, 0.9112, 0.7188}, {0.0807, 0.9104, 0.7228}, {0.0820, 0.9116, 0.7209}};
  for (const double tolerance : {3e-3, 1.5e-3, 6e-4, 2e-4}) {
    FitOptions options = within(tolerance);
    options.corner_angle = 180;
    const CurveFit fit = fit_points("stroke", stroke, options);
    double fastest = 0;
    for (int k = 0; k <= 2000; ++k)
      fastest = std::max(fastest, fit.curve.evaluate(fit.curve.end() * k / 2000, 1).norm());
    INFO(tolerance << ": " << fit.curve.segment_count() << " segments, |X'| up to " << fastest);
    CHECK(fastest < 8);
    CHECK(fit.deviation.max <= tolerance);
    CHECK(fit.deviation.between <= tolerance * (1 + 1e-9));
    for (size_t i = 1; i < stroke.size(); ++i)
      CHECK(fit.parameters[i] - fit.parameters[i - 1] >=
            0.399 * (stroke[i] - stroke[i - 1]).norm());
  }
}

TEST_CASE("the accuracy that the fit states between points is what the deviation reports",
          "[fairing][curve_fit]") {
  Random random(29);
  int strayed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Vec3> points = {Vec3::Zero()};
    Vec3 direction = random.point();
    const int n = 4 + trial % 12;
    for (int i = 1; i < n; ++i) {
      direction += 0.6 * random.point();
      points.push_back(points.back() + random.between(0.02, 1) * direction.normalized());
    }
    const double tolerance = std::pow(10, random.between(-2.5, -1));
    strayed += fit_points("stroke", points, within(tolerance)).deviation.between > tolerance;
  }
  CHECK(strayed <= 3);
}

TEST_CASE("rounds that cannot reach the tolerance are not begun, and move no parameter",
          "[fairing][curve_fit]") {
  CurveFitProblem once;
  once.tolerance = 1e-6;
  for (int i = 0; i <= 20; ++i) once.points.push_back({helix(i / 20.0), i / 20.0});
  once.node_constraints = {{0, helix(0), {}, {}}, {1, helix(1), {}, {}}};
  once.points.front().fixed_parameter = once.points.back().fixed_parameter = true;
  once.set_mesh({0, 0.5, 1}, {});
  CurveFitProblem often = once;
  once.iterate(1);
  often.iterate(30);
  CHECK(often.worst() > 1e-3);
  CHECK(often.dofs == once.dofs);
  for (int i = 0; i <= 20; ++i) CHECK(often.points[i].t == i / 20.0);
  // Outside the tolerance: more iterations come closer, and move the points.
  often.tolerance = once.tolerance = 0.8 * once.worst();
  once.iterate(1);
  often.iterate(30);
  CHECK(often.done());
  CHECK(often.points[7].t != 7 / 20.0);
}

TEST_CASE("where the curve has to go through all points, those of straight stretches go again",
          "[fairing][curve_fit]") {
  // No smooth curve with fewer nodes follows the spike: 6,000 nodes, then few.
  std::vector<Vec3> points = points_of(6000, [](double s) { return Vec3(1000 * s, 0, 0); });
  points[2500].y() = 40;
  points[4000].y() = -25;
  FitOptions options = within(1e-3);
  options.corner_angle = 180;
  const CurveFit fit = fit_points("spikes", points, options);
  CHECK(fit.deviation.max <= 1e-3);
  CHECK(farthest(fit.curve, points) <= 1.001e-3);
  CHECK(fit.curve.segment_count() < 40);
  const ThreadGuard one(1);
  const CurveFit alone = fit_points("spikes", points, options);
  CHECK(alone.curve.dofs() == fit.curve.dofs());
  CHECK(alone.parameters == fit.parameters);
}

TEST_CASE("a hundred thousand noisy points are fitted in few segments", "[fairing][curve_fit]") {
  Random random(23);
  auto points = points_of(100000, helix);
  for (Vec3& p : points) p += 0.001 * random.point();
  const CurveFit fit = fit_points("long", points, within(0.005));
  CHECK(fit.deviation.max <= 0.005);
  CHECK(fit.curve.segment_count() <= 8);
}
