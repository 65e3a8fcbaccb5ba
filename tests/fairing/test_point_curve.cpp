// SPDX-License-Identifier: MPL-2.0
// Curves through points: detected lines and arcs, explicit corners.
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

std::vector<Vec3> arc_at_seven(int points, double degrees) {
  std::vector<Vec3> all;
  for (int i = 0; i < points; ++i) {
    const double t = degrees * pi / 180 * i / (points - 1);
    all.emplace_back(50 * std::cos(t), 7, 50 * std::sin(t));
  }
  return all;
}

// Rounded rectangle of 100 by 60 with radius 8, closed, with `per` chords per corner.
std::vector<Vec3> rounded(int per) {
  std::vector<Vec3> all;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i <= per; ++i) {
      const double t = pi / 2 * (k + static_cast<double>(i) / per);
      all.emplace_back((k == 0 || k == 3 ? 42 : -42) + 8 * std::cos(t),
                       (k < 2 ? 22 : -22) + 8 * std::sin(t), 0);
    }
  all.push_back(all.front());
  return all;
}

double farthest(const InputCurve& curve, const std::function<double(const Vec3&)>& off) {
  double most = 0;
  for (int k = 0; k <= 2000; ++k)
    most = std::max(
        most,
        std::abs(off(curve.evaluate(curve.start() + (curve.end() - curve.start()) * k / 2000))));
  return most;
}

// Largest turn and jump of speed at the nodes.
std::pair<double, double> jumps(const InputCurve& curve) {
  double turning_angle = 0, speed = 0;
  const auto t = curve.breaks();
  for (size_t i = 1; i + 1 < t.size(); ++i) {
    const double e = 1e-9 * (curve.end() - curve.start());
    const Vec3 a = curve.evaluate(t[i] - e, 1), b = curve.evaluate(t[i] + e, 1);
    turning_angle = std::max(turning_angle, degrees_between(a, b));
    speed = std::max(speed, std::abs(a.norm() - b.norm()));
  }
  return {turning_angle, speed};
}

}  // namespace

TEST_CASE("points of an arc give the arc", "[fairing][point_curve]") {
  const auto off = [](const Vec3& p) { return Vec2(p.x(), p.z()).norm() - 50; };
  for (const auto& [points, within] : {std::pair(4, 1e-4), {5, 1e-5}, {9, 1e-7}, {17, 2e-9}}) {
    INFO(points);
    const auto curve = curve_through_points("arc", arc_at_seven(points, 180));
    CHECK(farthest(*curve, off) < 50 * within);
    CHECK(jumps(*curve).first < 1e-6);
    CHECK(jumps(*curve).second < 1e-6);
  }
  const auto circle = curve_through_points("circle", arc_at_seven(9, 360));
  CHECK(farthest(*circle, off) < 5e-4);
  CHECK(degrees_between(circle->evaluate(circle->start(), 1), circle->evaluate(circle->end(), 1)) <
        1e-6);
}

TEST_CASE("long sides between rounded corners are straight", "[fairing][point_curve]") {
  const auto off = [](const Vec3& p) {
    const Vec2 q(std::max(std::abs(p.x()) - 42, 0.0), std::max(std::abs(p.y()) - 22, 0.0));
    return q.x() > 0 && q.y() > 0 ? q.norm() - 8 : std::max(q.x(), q.y()) - 8;
  };
  for (const int per : {2, 3, 4, 8}) {
    INFO(per);
    const auto curve = curve_through_points("lid", rounded(per));
    CHECK(farthest(*curve, off) < (per == 2 ? 1e-4 : 1e-5));
    CHECK(jumps(*curve).first < 1e-5);
    CHECK(degrees_between(curve->evaluate(curve->start(), 1), curve->evaluate(curve->end(), 1)) <
          1e-5);
  }
}

TEST_CASE("a straight stretch stays straight beside a bow, symmetric curves are left alone",
          "[fairing][point_curve]") {
  std::vector<Vec3> points;
  for (int i = 0; i < 5; ++i) points.emplace_back(10 * i, 0, 0);
  for (int i = 1; i < 8; ++i) points.emplace_back(40 + 5 * i, 0.05 * i * i * i, 0);
  const auto curve = curve_through_points("sheer", points);
  for (int k = 0; k <= 100; ++k) CHECK(std::abs(curve->evaluate(0.4 * k).y()) < 1e-12);
  CHECK(jumps(*curve).first < 1e-6);
  // Three points at an inflection are collinear by symmetry, four around a vertex are concyclic.
  std::vector<Vec3> wave, bowl;
  for (int i = -4; i <= 4; ++i) wave.emplace_back(0.5 * i, std::sin(0.5 * i), 0);
  for (int i = -4; i < 4; ++i) bowl.emplace_back(i + 0.5, 0.1 * std::pow(i + 0.5, 2), 0);
  CHECK(find_lines_and_arcs(wave).empty());
  CHECK(find_lines_and_arcs(bowl).empty());
  CHECK(farthest(*curve_through_points("wave", wave),
                 [](const Vec3& p) { return p.y() - std::sin(p.x()); }) < 5e-3);
}

TEST_CASE("dense points of smooth curves are left to the spline", "[fairing][point_curve]") {
  for (const int count : {40, 54, 70, 100, 400}) {
    std::vector<Vec3> wave, ellipse;
    for (int i = 0; i <= count; ++i) {
      const double t = 2 * pi * i / count;
      wave.emplace_back(5 * t, std::sin(t), 0.1 * t * t);
      ellipse.emplace_back(3 * std::cos(t), 2 * std::sin(t), 0);
    }
    INFO(count);
    CHECK(find_lines_and_arcs(wave).empty());
    CHECK(find_lines_and_arcs(ellipse).empty());
    // C2: no jump of the second derivative.
    const auto curve = curve_through_points("wave", wave);
    const auto t = curve->breaks();
    for (size_t i = 1; i + 1 < t.size(); ++i)
      CHECK((curve->evaluate(t[i] - 1e-9, 2) - curve->evaluate(t[i] + 1e-9, 2)).norm() < 1e-6);
  }
}

TEST_CASE("corners may be stated", "[fairing][point_curve]") {
  const std::vector<Vec3> points = {{0, 0, 0},   {1, 0, 0},   {2, 0, 0},
                                    {3, 0.2, 0}, {4, 0.4, 0}, {5, 0.6, 0}};
  CHECK(curve_through_points("keel", points)->corners().empty());
  const auto stated = curve_through_points("keel", points, 20, std::vector<int>{2});
  REQUIRE(stated->corners().size() == 1);
  CHECK((stated->evaluate(stated->corners()[0]) - points[2]).norm() == 0);
  CHECK(jumps(*stated).first == Approx(std::atan(0.2) * 180 / pi).epsilon(1e-6));
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  const auto round = curve_through_points("ring", square, 20, std::vector<int>{});
  CHECK(round->corners().empty());
  CHECK(jumps(*round).first < 1e-6);
  CHECK_THROWS_WITH(curve_through_points("ring", square, 20, std::vector<int>{9}),
                    Contains("corner at point 10, expected 1 to 5"));
}
