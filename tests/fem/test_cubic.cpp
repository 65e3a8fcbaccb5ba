// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/cubic.h"

#include "batten/core/containers.h"
#include "batten/elements/hermite_segment.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten;
using namespace batten_test;

namespace {

BezierCubic<Vec3> random_cubic(Random& random) {
  return {{random.point(), random.point(), random.point(), random.point()}};
}

constexpr double kPlaces[] = {0, 0.1, 0.37, 0.5, 0.93, 1};

}  // namespace

TEST_CASE("the forms of a cubic have the same values and derivatives", "[fem][cubic]") {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const BezierCubic<Vec3> bezier = random_cubic(random);
    const auto power = PowerCubic<Vec3>::of_bezier(bezier);
    const double h = 0.3 + trial;
    const Vec3 p = bezier.at(0), q = bezier.at(1), dp = bezier.slope(0), dq = bezier.slope(1);
    const auto of_ends = PowerCubic<Vec3>::of_hermite(p, dp, q, dq);
    const auto again = BezierCubic<Vec3>::between(p, dp / 3, dq / 3, q);
    const HermiteSegment segment(h);
    for (const double t : kPlaces) {
      const Vec3 x = bezier.at(t), d = bezier.slope(t), dd = bezier.second(t);
      for (const auto& other : {power, of_ends}) {
        CHECK((other.at(t) - x).norm() < 1e-14);
        CHECK((other.slope(t) - d).norm() < 1e-13);
        CHECK((other.second(t) - dd).norm() < 1e-13);
      }
      CHECK((again.at(t) - x).norm() < 1e-14);
      CHECK((bezier.blossom(t, t, t) - x).norm() < 1e-14);
      CHECK((hermite_value<Vec3>(p, dp / h, q, dq / h, h, t) - x).norm() < 1e-14);
      for (int order = 0; order <= 2; ++order) {
        const auto H = segment.evaluate(t, order);
        const Vec3 by_shape_functions = H[0] * p + H[1] * dp / h + H[2] * q + H[3] * dq / h;
        const Vec3& expected = order == 0 ? x : order == 1 ? d : dd;
        CHECK((std::pow(h, order) * by_shape_functions - expected).norm() < 1e-12);
      }
    }
  }
}

TEST_CASE("a straight cubic has constant speed, and equal ends give equal values", "[fem][cubic]") {
  const Vec2 p(0.1, 0.7), q(-2.3, 1.9);
  const auto line = PlanarCubic::straight(p, q);
  for (const double t : kPlaces) {
    CHECK((line.at(t) - (p + t * (q - p))).norm() < 1e-15);
    CHECK((line.slope(t) - (q - p)).norm() < 1e-14);
    CHECK(hermite_value<Vec2>(p, Vec2::Zero(), p, Vec2::Zero(), 0.7, t) == p);
    CHECK(std::abs(smooth_step(t) + smooth_step(1 - t) - 1) < 1e-15);
  }
  CHECK(smooth_step(0) == 0);
  CHECK(smooth_step(1) == 1);
}

TEST_CASE("the blossom is symmetric, and its values are the Bézier points of a part",
          "[fem][cubic]") {
  Random random(2);
  const BezierCubic<Vec3> cubic = random_cubic(random);
  const double a = 0.2, b = 0.7, c = 0.4;
  const Vec3 value = cubic.blossom(a, b, c);
  for (const auto& [x, y, z] : {std::array{a, c, b}, {b, a, c}, {b, c, a}, {c, a, b}, {c, b, a}})
    CHECK((cubic.blossom(x, y, z) - value).norm() < 1e-15);
  const BezierCubic<Vec3> part = cubic.part(a, b);
  CHECK((cubic.blossom(a, a, a) - part.b[0]).norm() < 1e-15);
  CHECK((cubic.blossom(a, a, b) - part.b[1]).norm() < 1e-15);
  CHECK((cubic.blossom(a, b, b) - part.b[2]).norm() < 1e-15);
  CHECK((cubic.blossom(b, b, b) - part.b[3]).norm() < 1e-15);
  CHECK(part.b[0] == cubic.at(a));
  CHECK(part.b[3] == cubic.at(b));
}

TEST_CASE("a coordinate of a planar cubic is a cubic", "[fem][cubic]") {
  Random random(4);
  const PlanarCubic arc{{Vec2(random(), random()), Vec2(random(), random()),
                         Vec2(random(), random()), Vec2(random(), random())}};
  for (const int axis : {0, 1})
    for (const double t : kPlaces) {
      CHECK(BernsteinCubic::coordinate(arc, axis).at(t) == Approx(arc.at(t)[axis]).margin(1e-15));
      CHECK(BernsteinCubic::coordinate(arc, axis, 0.3).at(t) ==
            Approx(arc.at(t)[axis] - 0.3).margin(1e-15));
    }
}

TEST_CASE("a cubic's zeros are found where its sign changes", "[fem][cubic]") {
  Random random(3);
  const auto from_roots = [](double scale, double a, double b, double c) {
    // The blossom of (t - a)(t - b)(t - c) at 000, 001, 011, 111.
    BernsteinCubic f;
    for (int k = 0; k < 4; ++k) {
      double sum = 0;
      const double t[3] = {k > 0 ? 1. : 0, k > 1 ? 1. : 0, k > 2 ? 1. : 0};
      const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
      for (const auto& o : order) sum += (t[o[0]] - a) * (t[o[1]] - b) * (t[o[2]] - c) / 6;
      f.b[static_cast<size_t>(k)] = scale * sum;
    }
    return f;
  };
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> roots{random.between(-1, 2), random.between(-1, 2), random.between(-1, 2)};
    std::sort(roots.begin(), roots.end());
    if (roots[1] - roots[0] < 1e-3 || roots[2] - roots[1] < 1e-3) continue;
    const BernsteinCubic f =
        from_roots(std::pow(10, 3 * random()) * (trial % 2 ? 1 : -1), roots[0], roots[1], roots[2]);
    const auto found = f.zeros();
    std::vector<double> expected;
    for (const double r : roots)
      if (r > 0 && r < 1) expected.push_back(r);
    REQUIRE(found.size() == expected.size());
    for (size_t i = 0; i < found.size(); ++i) CHECK(std::abs(found[i] - expected[i]) < 1e-11);
    const auto parts = f.monotone_parts();
    CHECK(parts.front() == 0);
    CHECK(parts.back() == 1);
    for (size_t i = 0; i + 1 < parts.size(); ++i) {
      CHECK(parts[i] < parts[i + 1]);
      if (i > 0)
        CHECK(std::abs(f.slope(parts[i])) <
              1e-12 * std::abs(f.b[3] - f.b[0] + f.b[1]) + 1e-11 * Vec2(f.b[0], f.b[3]).norm());
    }
  }
  // A double root: a tangent point, or (by rounding) two adjacent intersections.
  for (const double a : {0.1, 0.25, 0.5, 0.7, 1 / 3.}) {
    const auto found = from_roots(1, a, a, 1.7).zeros();
    CHECK(found.size() % 2 == 0);
    for (const double z : found) CHECK(std::abs(z - a) < 1e-7);
    const auto triple = from_roots(1, a, a, a).zeros();
    REQUIRE(triple.size() % 2 == 1);
    for (const double z : triple) CHECK(std::abs(z - a) < 2e-5);
  }
  // Roots at the ends: 0 counts as positive, so that a chain of cubics detects an intersection
  // once.
  CHECK(BernsteinCubic{{0, 1, 2, 3}}.zeros().empty());
  CHECK(BernsteinCubic{{-3, -2, -1, 0}}.zeros() == std::vector<double>{1});
  REQUIRE(BernsteinCubic{{0, -1, -2, -3}}.zeros().size() == 1);
  CHECK(BernsteinCubic{{0, -1, -2, -3}}.zeros()[0] < 1e-15);
  CHECK(BernsteinCubic{{3, 2, 1, 0}}.zeros().empty());
  CHECK(BernsteinCubic{{0, 0, 0, 0}}.zeros().empty());
  CHECK(BernsteinCubic{{1, -1, -1, 1}}.zeros().size() == 2);
  CHECK(BernsteinCubic{{-1, 0, 0, 1}}.zeros() == std::vector<double>{0.5});
}

TEST_CASE("part of an arc is the same curve", "[fem][cubic]") {
  Random random(5);
  const auto point = [&] { return Vec2(random(), random()); };
  for (int trial = 0; trial < 50; ++trial) {
    const PlanarCubic arc{{point(), point(), point(), point()}};
    const double t0 = random.between(0, 1), t1 = random.between(0, 1);
    const PlanarCubic part = arc.part(t0, t1);
    for (const double s : {0., 0.3, 0.8, 1.}) {
      CHECK((part.at(s) - arc.at(t0 + s * (t1 - t0))).norm() < 1e-14);
      CHECK((part.slope(s) - (t1 - t0) * arc.slope(t0 + s * (t1 - t0))).norm() < 1e-13);
    }
  }
}

TEST_CASE("slopes of interpolating splines satisfy their end conditions and join C2",
          "[fem][cubic]") {
  Random random(6);
  const std::vector<double> knots = {-1, -0.2, 0.1, 1.4, 1.5, 3};
  Points values(6, 3);
  for (int i = 0; i < 6; ++i) values.row(i) = random.point();
  // Second and third derivatives of piece i, with respect to the parameter.
  const auto piece = [&](const Points& slopes, int i) {
    const double h = knots[i + 1] - knots[i];
    return PowerCubic<Vec3>::of_hermite(values.row(i), h * slopes.row(i), values.row(i + 1),
                                        h * slopes.row(i + 1));
  };
  const auto second = [&](const Points& slopes, int i, double t) {
    const double h = knots[i + 1] - knots[i];
    return Vec3(piece(slopes, i).second(t) / (h * h));
  };
  for (const SplineEnd first : {SplineEnd::Natural, SplineEnd::Parabolic, SplineEnd::Given})
    for (const SplineEnd last : {SplineEnd::Natural, SplineEnd::Parabolic, SplineEnd::Given}) {
      Points slopes = Points::Constant(6, 3, 0.25);
      spline_slopes(knots, values, first, last, slopes);
      for (int i = 0; i + 2 < 6; ++i)
        CHECK((second(slopes, i, 1) - second(slopes, i + 1, 0)).norm() < 1e-10);
      const auto check_end = [&](SplineEnd end, int knot, int at_piece, double t) {
        if (end == SplineEnd::Given) CHECK(slopes.row(knot) == Points::Constant(1, 3, 0.25));
        if (end == SplineEnd::Natural) CHECK(second(slopes, at_piece, t).norm() < 1e-12);
        if (end == SplineEnd::Parabolic) CHECK(piece(slopes, at_piece).c3.norm() < 1e-13);
      };
      check_end(first, 0, 0, 0);
      check_end(last, 5, 4, 1);
    }
}

TEST_CASE("splines through two points: straight, or with the given slope", "[fem][cubic]") {
  const std::vector<double> knots = {1, 3};
  Points values(2, 3);
  values << 0, 1, 2, 4, -1, 2;
  const Eigen::RowVector3d secant = (values.row(1) - values.row(0)) / 2;
  for (const SplineEnd end : {SplineEnd::Natural, SplineEnd::Parabolic}) {
    Points slopes = Points::Zero(2, 3);
    spline_slopes(knots, values, end, end, slopes);
    for (int i = 0; i < 2; ++i) CHECK((slopes.row(i) - secant).norm() < 1e-15);
  }
  Points slopes = Points::Zero(2, 3);
  slopes.row(0) = Vec3(1, 0, 0).transpose();
  spline_slopes(knots, values, SplineEnd::Given, SplineEnd::Parabolic, slopes);
  CHECK((slopes.row(1) - (2 * secant - slopes.row(0))).norm() < 1e-15);
}

TEST_CASE("piecewise cubics reject knots that do not ascend", "[fem][cubic]") {
  CHECK_THROWS_AS(
      PiecewiseCubic::through({0, 1, 1}, Points::Zero(3, 3), PiecewiseCubic::Ends::Natural),
      std::logic_error);
}

TEST_CASE("curves through points bend evenly, and not at their ends", "[fem][cubic]") {
  Random random(27);
  const std::vector<double> knots = {0, 0.3, 1.9, 2, 5};
  Points values(5, 3);
  for (int i = 0; i < 5; ++i) values.row(i) = random.point();
  // Slopes are parabolas in each segment: three of them give the second derivative at its ends.
  const auto bend = [](const PiecewiseCubic& curve, double at, double to) {
    const double h = (to - at) / 2, near = at + 1e-9 * h;
    return Vec3((4 * curve.slope(at + h) - 3 * curve.slope(near) - curve.slope(to)) / (2 * h));
  };
  for (const auto ends : {PiecewiseCubic::Ends::Natural, PiecewiseCubic::Ends::Flat}) {
    const PiecewiseCubic curve = PiecewiseCubic::through(knots, values, ends);
    for (int i = 0; i < 5; ++i) CHECK((curve.at(knots[i]) - values.row(i).transpose()).norm() == 0);
    for (int i = 1; i < 4; ++i)
      CHECK((bend(curve, knots[i], knots[i - 1]) - bend(curve, knots[i], knots[i + 1])).norm() <
            1e-6);
    const bool flat = ends == PiecewiseCubic::Ends::Flat;
    CHECK((flat ? curve.slope(0) : bend(curve, 0, 0.3)).norm() < 1e-6);
    CHECK((flat ? curve.slope(5) : bend(curve, 5, 2)).norm() < 1e-6);
    for (const double u : {0.1, 1.0, 4.4})
      CHECK((curve.slope(u) - (curve.at(u + 1e-6) - curve.at(u - 1e-6)) / 2e-6).norm() < 1e-7);
  }
}

TEST_CASE("fitted curves reproduce cubics", "[fem][cubic]") {
  Random random(28);
  const Vec3 a = random.point(), b = random.point(), c = random.point(), d = random.point();
  std::vector<double> u;
  Points values(41, 3);
  for (int i = 0; i <= 40; ++i) {
    u.push_back(2 + 0.1 * i);
    values.row(i) = a + u[i] * (b + u[i] * (c + u[i] * d));
  }
  for (const int spans : {1, 2, 7}) {
    const PiecewiseCubic curve = PiecewiseCubic::fitted(u, values, spans);
    for (double t = 2; t <= 6; t += 0.13) {
      CHECK((curve.at(t) - a - t * (b + t * (c + t * d))).norm() < 1e-10);
      CHECK((curve.slope(t) - b - t * (2 * c + 3 * t * d)).norm() < 1e-10);
    }
  }
}
