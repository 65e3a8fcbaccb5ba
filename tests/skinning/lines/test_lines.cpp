// SPDX-License-Identifier: MPL-2.0
// Input curves, their fits, the loop and its polygon.
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/region/polygon_fit.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_lines.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

std::shared_ptr<const InputCurve> helix(double turns) {
  return curve_from_formula(0, 2 * std::numbers::pi * turns, [](double t, int order) -> Vec3 {
    switch (order) {
      case 0:
        return {std::cos(t), std::sin(t), 0.3 * t};
      case 1:
        return {-std::sin(t), std::cos(t), 0.3};
      default:
        return {-std::cos(t), -std::sin(t), 0};
    }
  });
}

HermiteCurve fit(const std::shared_ptr<const InputCurve>& curve, double tolerance) {
  FitOptions options;
  options.tolerance = tolerance;
  options.corner_angle = 180;
  options.fixed_parameters = true;
  options.start = {curve->evaluate(curve->start()),
                   curve->evaluate(curve->start(), 1).normalized()};
  options.end = {curve->evaluate(curve->end()), curve->evaluate(curve->end(), 1).normalized()};
  return fit_curve("line", curve, options);
}

}  // namespace

TEST_CASE("a curve through points passes them, is C2 between corners and breaks at corners",
          "[skinning][curves]") {
  std::vector<Vec3> points;
  for (int i = 0; i <= 10; ++i) points.emplace_back(i * 0.4, std::sin(0.3 * i), 0.2 * i);
  const auto curve = curve_through_points("line", points);
  REQUIRE(curve->breaks().size() == points.size());
  for (size_t i = 0; i < points.size(); ++i)
    CHECK((curve->evaluate(curve->breaks()[i]) - points[i]).norm() < 1e-14);
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    const double t = curve->breaks()[i];
    CHECK((curve->evaluate(t - 1e-9, 1) - curve->evaluate(t + 1e-9, 1)).norm() < 1e-7);
    CHECK((curve->evaluate(t - 1e-9, 2) - curve->evaluate(t + 1e-9, 2)).norm() < 1e-6);
  }
  // The curvature at the ends is that of the neighbourhood.
  CHECK((curve->evaluate(curve->start(), 2) - curve->evaluate(curve->breaks()[1], 2)).norm() <
        1e-9);
  const auto bow = curve_through_points("bow", {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}}, 100);
  const double half = bow->breaks()[1] / 2;
  CHECK((bow->evaluate(half) - Vec3(0.5, 0.75, 0)).norm() < 1e-12);
  const auto bent =
      curve_through_points("line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}});
  const auto parts = split_at_corners({"line", bent}, 20);
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].name == "line.1");
  CHECK((parts[0].curve->evaluate(parts[0].curve->end(), 1).normalized() - Vec3(1, 0, 0)).norm() <
        1e-9);
  CHECK((parts[1].curve->evaluate(parts[1].curve->start(), 1).normalized() - Vec3(0, 1, 0)).norm() <
        1e-9);
}

TEST_CASE("points that form no curve are refused by name", "[skinning][curves]") {
  CHECK_THROWS_WITH(curve_through_points("rim", {{0, 0, 0}}),
                    Contains("'rim'") && Contains("two or more"));
  CHECK_THROWS_WITH(curve_through_points("rim", {{0, 0, 0}, {0, 0, 0}}), Contains("zero length"));
  CHECK_THROWS_WITH(curve_through_points("rim", {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
                    Contains("points 2 and 3 are duplicates"));
  CHECK_THROWS_WITH(curve_through_points("rim", {{0, 0, 0}, {NAN, 0, 0}}),
                    Contains("point 2") && Contains("finite"));
}

TEST_CASE("the parts between corners have the breaks of the whole curve", "[skinning][curves]") {
  std::vector<Vec3> points;
  for (int i = 0; i < 40; ++i) points.emplace_back(i, std::abs(i % 8 - 4), 0);
  const auto whole = curve_through_points("zigzag", points, 20);
  const std::vector<SmoothSegment> parts = split_at_corners({"zigzag", whole}, 20);
  REQUIRE(parts.size() > 5);
  std::vector<double> breaks{whole->start()};
  for (const SmoothSegment& part : parts) {
    const std::vector<double> own = part.curve->breaks();
    CHECK(own.front() == breaks.back());
    breaks.insert(breaks.end(), own.begin() + 1, own.end());
  }
  CHECK(breaks == whole->breaks());
  const std::vector<double> turned = reversed(whole)->breaks();
  REQUIRE(turned.size() == breaks.size());
  for (size_t i = 0; i < turned.size(); ++i) CHECK(turned[i] == -breaks[breaks.size() - 1 - i]);
}

TEST_CASE("arc length and its inverse", "[skinning][curves]") {
  const ArcLength arc(helix(1));
  const double speed = std::sqrt(1 + 0.09);
  CHECK(arc.total() == Approx(2 * std::numbers::pi * speed).epsilon(1e-13));
  for (const double s : {0.1, 1.0, 3.3, 6.0})
    CHECK(arc.parameter(s) == Approx(s / speed).epsilon(1e-12));
}

TEST_CASE("a fit with given ends reaches its tolerance, with fourth-order economy",
          "[skinning][curves]") {
  const auto curve = helix(1);
  int before = 0;
  for (const double tolerance : {1e-3, 1e-5, 1e-7}) {
    const HermiteCurve fitted = fit(curve, tolerance);
    double worst = 0;
    for (int i = 0; i <= 1000; ++i)
      worst = std::max(
          worst, fitted.closest_point(curve->evaluate(2 * std::numbers::pi * i / 1000)).distance);
    CHECK(worst <= tolerance);
    CHECK(worst > 1e-4 * tolerance);  // no more nodes than necessary
    for (int i = 0; i < fitted.node_count(); ++i)
      CHECK(fitted.slope_out(i).norm() == Approx(1).epsilon(1e-2));
    if (before > 0) CHECK(fitted.node_count() <= 5 * before);
    before = fitted.node_count();
  }
  const auto corner = curve_through_points("line", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  CHECK_THROWS_WITH(fit(corner, 1e-6), Contains("corner"));
}

TEST_CASE("piecewise cubics are kept, in their own parameter", "[skinning][curves]") {
  const auto curve = bezier_curve({0, 0, 0}, {1, 0, 1}, {2, 1, 1}, {3, 1, 0});
  const auto exact = reuse_cubic_input({"line", CharacterLine::Role::Outline, curve}, 0.1,
                                       curve->evaluate(0), curve->evaluate(1));
  REQUIRE(exact);
  const HermiteCurve& kept = *exact;
  REQUIRE(kept.node_count() == 2);
  for (const double t : {0.1, 0.5, 0.77})
    CHECK((kept.evaluate(t * kept.end()) - curve->evaluate(t)).norm() < 1e-15);
  CHECK(!reuse_cubic_input({"line", CharacterLine::Role::Outline, helix(1)}, 0.1, {1, 0, 0},
                           {1, 0, 1}));
}

TEST_CASE("a polygon with consistent lengths and angles is found exactly", "[skinning][curves]") {
  // An L with a reflex corner.
  const std::vector<Vec3> corners = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0},
                                     {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const double right = std::numbers::pi / 2;
  const auto polygon = fit_polygon(
      {3, 1, 2, 1, 1, 2}, {right, right, right, 3 * right, right, right}, corners, Vec3::UnitZ());
  for (size_t i = 0; i < 6; ++i)
    for (size_t j = 0; j < i; ++j)
      CHECK((polygon[i] - polygon[j]).norm() ==
            Approx((corners[i] - corners[j]).norm()).epsilon(1e-9));
}

TEST_CASE("invalid loops are refused with the reason", "[skinning][curves]") {
  const auto outline = [](std::vector<CharacterLine> lines) {
    SkinOptions options;
    options.mesher = SkinOptions::Mesher::Fan;
    RegionLayout layout("region", lines, options);
  };
  auto open = polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  open.pop_back();
  CHECK_THROWS_WITH(outline(open), Contains("open") && Contains("'side 1'") && Contains("away"));
  CHECK_THROWS_WITH(outline(polygon_lines({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}})),
                    Contains("'side 1' and 'side 3'") && Contains("intersect or touch") &&
                        Contains("(0.5, 0.5, 0)"));
  CHECK_THROWS_WITH(outline(polygon_lines({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}})),
                    Contains("one straight line"));
  CHECK_THROWS_WITH(outline({{"ring", helix(0.9)}}), Contains("open"));
  auto two = polygon_lines({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}});
  for (auto& line : polygon_lines({{1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}})) {
    line.name = "hole " + line.name;
    two.push_back(line);
  }
  CHECK_THROWS_WITH(outline(two), Contains("2 loops") && Contains("'side 1'") &&
                                      Contains("'hole side 1'") && Contains("role = \"hole\""));
  auto doubled = polygon_lines({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  doubled.push_back({"again", doubled[0].curve});
  CHECK_THROWS_WITH(outline(doubled), Contains("'side 1'") && Contains("'again'"));
  const auto eight =
      curve_from_formula(0.3, 2 * std::numbers::pi + 0.1, [](double t, int order) -> Vec3 {
        if (order == 0) return {std::sin(2 * t), std::sin(t), 0};
        return {2 * std::cos(2 * t), std::cos(t), 0};
      });
  CHECK_THROWS_WITH(outline({{"eight", eight}}), Contains("'eight' intersects itself"));
}
