// SPDX-License-Identifier: MPL-2.0
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

// Largest difference between the derivatives and finite differences of the curve.
double error_of_derivatives(const InputCurve& curve) {
  double most = 0;
  const double h = 1e-5 * (curve.end() - curve.start());
  for (int k = 1; k < 40; ++k) {
    const double t = curve.start() + (curve.end() - curve.start()) * (k + 0.123) / 41;
    for (const int order : {1, 2}) {
      const Vec3 exact = curve.evaluate(t, order);
      const Vec3 difference =
          (curve.evaluate(t + h, order - 1) - curve.evaluate(t - h, order - 1)) / (2 * h);
      most = std::max(most, (exact - difference).norm() / std::max(1.0, exact.norm()));
    }
  }
  return most;
}

}  // namespace

TEST_CASE("arcs, ellipses and helices are their formulas", "[fairing][curve_shapes]") {
  const auto half = arc_through({5, 0, 1}, {0, 5, 1}, {-5, 0, 1});
  CHECK(ArcLength(half).total() == Approx(5 * pi));
  CHECK((half->evaluate(half->end()) - Vec3(-5, 0, 1)).norm() < 1e-14);
  const auto other = arc_through({5, 0, 1}, {0, -5, 1}, {0, 5, 1});
  CHECK(ArcLength(other).total() == Approx(7.5 * pi));
  const CurvePlane plane = curve_plane({1, 2, 3}, {0, 1, 1}, {1, 0, 0});
  CHECK(plane.x.cross(plane.y).dot(Vec3(0, 1, 1)) == Approx(std::sqrt(2)));
  const auto ellipse = ellipse_arc(plane, 3, 2, 0, -pi);
  for (int k = 0; k <= 20; ++k) {
    const Vec3 d = ellipse->evaluate(ellipse->end() * k / 20) - plane.centre;
    CHECK(std::pow(d.dot(plane.x) / 3, 2) + std::pow(d.dot(plane.y) / 2, 2) == Approx(1));
    CHECK(d.dot(plane.y) < 1e-12);  // reversed
    CHECK(std::abs(d.dot(plane.normal())) < 1e-12);
  }
  const auto screw = helix(plane, 2, 3, 2.5);
  CHECK(ArcLength(screw).total() == Approx(2.5 * std::hypot(4 * pi, 3)));
  CHECK((screw->evaluate(screw->end()) - screw->evaluate(0)).dot(plane.normal()) == Approx(7.5));
  for (const auto& curve : {half, other, ellipse, screw})
    CHECK(error_of_derivatives(*curve) < 1e-7);
}

TEST_CASE("a rectangle has its sides and corners", "[fairing][curve_shapes]") {
  const CurvePlane plane;
  const auto sharp = rectangle(plane, 100, 60, 0), round = rectangle(plane, 100, 60, 8);
  CHECK(ArcLength(sharp).total() == Approx(320));
  CHECK(ArcLength(round).total() == Approx(320 - 64 + 16 * pi));
  for (const auto& curve : {sharp, round}) {
    CHECK((curve->evaluate(curve->end()) - curve->evaluate(0)).norm() < 1e-12);
    CHECK((curve->evaluate(0) - Vec3(0, -30, 0)).norm() < 1e-12);
    CHECK(curve->evaluate(1).x() == Approx(1));
  }
  const auto t = round->breaks();
  for (size_t i = 1; i + 1 < t.size(); ++i)
    CHECK((round->evaluate(t[i] - 1e-9, 1) - round->evaluate(t[i] + 1e-9, 1)).norm() < 1e-6);
  CHECK(ArcLength(rectangle(plane, 20, 20, 10)).total() == Approx(20 * pi));
}

TEST_CASE("splines by their poles: Bézier, circle by weights, multiple knots",
          "[fairing][curve_shapes]") {
  const std::vector<Vec3> p = {{0, 0, 0}, {1, 2, 0}, {3, 2, 1}, {4, 0, 0}, {6, 1, 2}};
  const auto bezier = bezier_curve(p[0], p[1], p[2], p[3]),
             same = nurbs_curve(3, {p.begin(), p.end() - 1}, {}, {});
  for (int k = 0; k <= 10; ++k)
    for (const int order : {0, 1, 2})
      CHECK((bezier->evaluate(k / 10.0, order) - same->evaluate(k / 10.0, order)).norm() < 1e-12);
  CHECK(same->piecewise_cubic());
  const double w = std::sqrt(0.5);
  const auto quarter = nurbs_curve(2, {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {1, w, 1}, {});
  CHECK_FALSE(quarter->piecewise_cubic());
  for (int k = 0; k <= 20; ++k)
    CHECK(quarter->evaluate(k / 20.0).norm() == Approx(1).epsilon(1e-14));
  const auto kinked = nurbs_curve(2, p, {}, {0, 0, 0, 1, 1, 2, 2, 2});
  CHECK(kinked->breaks() == std::vector<double>{0, 1, 2});
  CHECK((kinked->evaluate(1) - p[2]).norm() < 1e-14);
  const auto five = nurbs_curve(4, p, {1, 2, 1, 3, 1}, {});
  for (const auto& curve :
       {same, quarter, five, nurbs_curve(3, p, {}, {}), nurbs_curve(1, p, {}, {})})
    CHECK(error_of_derivatives(*curve) < 1e-7);
}

TEST_CASE("the pieces of a long curve are found at and between their ends",
          "[fairing][curve_shapes]") {
  // Straight pieces of lengths 1, 2, 3, 1, …, each in another direction.
  std::vector<std::shared_ptr<const InputCurve>> pieces;
  std::vector<Vec3> slopes;
  std::vector<double> starts{0};
  Vec3 at = Vec3::Zero();
  for (int i = 0; i < 500; ++i) {
    const Vec3 slope(std::cos(i), std::sin(i), 0.1 * (i % 7));
    const double length = 1 + i % 3;
    const Vec3 from = at;
    pieces.push_back(curve_from_formula(0, length, [=](double t, int order) -> Vec3 {
      return order == 0 ? Vec3(from + t * slope) : order == 1 ? slope : Vec3::Zero();
    }));
    slopes.push_back(slope);
    starts.push_back(starts.back() + length);
    at += length * slope;
  }
  const auto whole = concatenated(pieces);
  CHECK(whole->breaks() == starts);
  double worst = 0;
  for (size_t i = 0; i < pieces.size(); ++i)
    for (const double t : {0.0, 1e-9, 0.5 * pieces[i]->end(), pieces[i]->end() - 1e-9}) {
      worst = std::max(worst, (whole->evaluate(starts[i] + t) - pieces[i]->evaluate(t)).norm());
      worst = std::max(worst, (whole->evaluate(starts[i] + t, 1) - slopes[i]).norm());
    }
  CHECK(worst < 1e-12);
  CHECK((whole->evaluate(whole->end(), 1) - slopes.back()).norm() == 0);
  CHECK((whole->evaluate(-1, 1) - slopes.front()).norm() == 0);

  // A spline of degree 1 has other slopes at its knots, on the side where the piece begins.
  std::vector<Vec3> poles{Vec3::Zero()};
  for (size_t i = 0; i < pieces.size(); ++i)
    poles.push_back(poles.back() + (starts[i + 1] - starts[i]) * slopes[i]);
  std::vector<double> knots = starts;
  knots.insert(knots.begin(), starts.front());
  knots.push_back(starts.back());
  const auto spline = nurbs_curve(1, poles, {}, knots);
  worst = 0;
  for (size_t i = 0; i < pieces.size(); ++i)
    for (const double t : {starts[i], 0.5 * (starts[i] + starts[i + 1])}) {
      worst = std::max(worst, (spline->evaluate(t) - whole->evaluate(t)).norm());
      worst = std::max(worst, (spline->evaluate(t, 1) - slopes[i]).norm());
    }
  CHECK(worst < 1e-11);
}

TEST_CASE("arc length far from the origin has the accuracy of the coordinates",
          "[fairing][curve_shapes]") {
  int calls = 0;
  const auto away = [&](double distance) {
    calls = 0;
    const Vec3 centre(distance, -0.3 * distance, 0);
    return ArcLength(curve_from_formula(0, pi,
                                        [=, &calls](double t, int order) -> Vec3 {
                                          ++calls;
                                          const double a = t + order * pi / 2;
                                          const Vec3 p(std::cos(a), std::sin(a), 0);
                                          if (order == 0) return centre + p;
                                          // The derivative of a cubic with these coordinates has their rounding errors.
                                          return (Vec3(centre + p) - centre).eval();
                                        }))
        .total();
  };
  CHECK(std::abs(away(0) - pi) < 1e-13);
  const int near = calls;
  CHECK(std::abs(away(1e6) - pi) < 1e-9);
  CHECK(calls < 4 * near);
}

TEST_CASE("copies are where they are put", "[fairing][curve_shapes]") {
  const auto arc = arc_through({5, 0, 1}, {0, 5, 1}, {-5, 0, 1});
  const AffineTransform there =
      scaling_about({0, 0, 1}, 2).then(rotation_about({0, 0, 0}, {0, 0, 1}, pi / 2));
  const auto copy = transformed(arc, there.then(reflection_in({0, 0, 0}, {0, 0, 3})));
  CHECK((copy->evaluate(copy->start()) - Vec3(0, 10, -1)).norm() < 1e-13);
  CHECK(error_of_derivatives(*copy) < 1e-7);
  CHECK(ArcLength(copy).total() == Approx(10 * pi));
}

TEST_CASE("invalid descriptions of curves are refused with the reason", "[fairing][curve_shapes]") {
  const CurvePlane plane;
  CHECK_THROWS_WITH(arc_through({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), Contains("collinear"));
  CHECK_THROWS_WITH(ellipse_arc(plane, -1, 1, 0, 1), Contains("found the radius -1"));
  CHECK_THROWS_WITH(ellipse_arc(plane, 1, 1, 0, 7), Contains("360 apart"));
  CHECK_THROWS_WITH(helix(plane, 1, 1, 0), Contains("number of turns"));
  CHECK_THROWS_WITH(rectangle(plane, 10, 4, 3), Contains("expected 0 to 2"));
  CHECK_THROWS_WITH(curve_plane({0, 0, 0}, {0, 0, 1}, {0, 0, 2}),
                    Contains("parallel to the normal"));
  CHECK_THROWS_WITH(nurbs_curve(3, {{0, 0, 0}, {1, 0, 0}}, {}, {}), Contains("expected 4 or more"));
  const std::vector<Vec3> p = {{0, 0, 0}, {1, 1, 0}, {2, 0, 0}};
  CHECK_THROWS_WITH(nurbs_curve(2, p, {1, 1}, {}), Contains("one for each"));
  CHECK_THROWS_WITH(nurbs_curve(2, p, {1, 0, 1}, {}), Contains("weights above 0"));
  CHECK_THROWS_WITH(nurbs_curve(2, p, {}, {0, 0, 0, 1, 1}), Contains("expected 6"));
  CHECK_THROWS_WITH(nurbs_curve(2, p, {}, {0, 0, 1, 0, 1, 1}), Contains("do not decrease"));
}
