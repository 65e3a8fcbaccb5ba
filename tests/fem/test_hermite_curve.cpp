// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/curves/hermite_curve.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

using std::numbers::pi;

// Nodes from a function u → (X, X').
template <class Function>
HermiteCurve interpolate(const std::vector<double>& u, const Function& f) {
  Points X(u.size(), 3), D(u.size(), 3);
  for (size_t i = 0; i < u.size(); ++i) {
    const auto [x, d] = f(u[i]);
    X.row(static_cast<long>(i)) = x;
    D.row(static_cast<long>(i)) = d;
  }
  return {u, X, D};
}

// An arc of radius R over `angle`, by arc length.
HermiteCurve arc(double R, double angle, int segments) {
  std::vector<double> u;
  for (int i = 0; i <= segments; ++i) u.push_back(R * angle * i / segments);
  return interpolate(u, [&](double s) {
    const double a = s / R;
    return std::pair(Vec3(R * std::cos(a), R * std::sin(a), 0), Vec3(-std::sin(a), std::cos(a), 0));
  });
}

HermiteCurve random_curve(unsigned seed, int nodes) {
  Random random(seed);
  std::vector<double> u{random()};
  Points X(nodes, 3), D(nodes, 3);
  for (int i = 0; i < nodes; ++i) {
    if (i > 0) u.push_back(u.back() + 1 + 0.3 * random());
    X.row(i) = Vec3(i, 0, 0) + 0.3 * random.point();
    D.row(i) = Vec3(1, 0, 0) + random.point();
  }
  return {u, X, D};
}

// Smallest distance by dense samples and golden-section search around each of the best ones.
double distance_by_search(const HermiteCurve& curve, const Vec3& p) {
  const int samples = 400 * (curve.node_count() - 1);
  const double step = (curve.end() - curve.start()) / samples;
  const auto distance = [&](double u) { return (curve.evaluate(u) - p).norm(); };
  double best = std::numeric_limits<double>::infinity(), at = 0;
  for (int i = 0; i <= samples; ++i)
    if (const double d = distance(curve.start() + i * step); d < best) {
      best = d;
      at = curve.start() + i * step;
    }
  double low = std::max(curve.start(), at - step), high = std::min(curve.end(), at + step);
  for (int i = 0; i < 80; ++i) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    (distance(a) < distance(b) ? high : low) = distance(a) < distance(b) ? b : a;
  }
  return std::min(best, distance(0.5 * (low + high)));
}

}  // namespace

TEST_CASE("a curve takes its nodes' positions and derivatives, and is C1 at them",
          "[fem][hermite_curve]") {
  const HermiteCurve curve = random_curve(1, 6);
  REQUIRE(curve.node_count() == 6);
  CHECK(curve.start() == curve.parameters().front());
  CHECK(curve.end() == curve.parameters().back());
  for (int i = 0; i < 6; ++i) {
    const double u = curve.parameters()[i];
    CHECK((curve.evaluate(u) - curve.position(i)).norm() < 1e-14);
    CHECK((curve.evaluate(u, 1) - curve.slope_out(i)).norm() < 1e-13);
    const double below = std::nextafter(u, -10.0);
    CHECK((curve.evaluate(below) - curve.evaluate(u)).norm() < 1e-13);
    CHECK((curve.evaluate(below, 1) - curve.evaluate(u, 1)).norm() < 1e-12);
  }
  // At a node the segment that starts there is evaluated; at the last one, the last segment.
  const double u2 = curve.parameters()[2];
  CHECK((curve.evaluate(u2, 2) - curve.evaluate(u2 + 1e-9, 2)).norm() < 1e-6);
  CHECK((curve.evaluate(u2, 2) - curve.evaluate(u2 - 1e-9, 2)).norm() > 1e-2);
  CHECK((curve.evaluate(curve.end(), 3) - curve.evaluate(curve.end() - 1e-3, 3)).norm() < 1e-12);
  // Outside, parameters are clamped to the ends.
  CHECK(curve.evaluate(curve.start() - 5) == curve.evaluate(curve.start()));
  CHECK(curve.evaluate(curve.end() + 5) == curve.evaluate(curve.end()));
}

TEST_CASE("curve derivatives are those of the order below, by central differences",
          "[fem][hermite_curve]") {
  const HermiteCurve curve = random_curve(2, 5);
  constexpr double step = 1e-5;
  for (int i = 0; i < 4; ++i) {
    const double u = 0.3 * curve.parameters()[i] + 0.7 * curve.parameters()[i + 1];
    for (int order = 1; order <= 3; ++order) {
      const Vec3 difference =
          (curve.evaluate(u + step, order - 1) - curve.evaluate(u - step, order - 1)) / (2 * step);
      CHECK((difference - curve.evaluate(u, order)).norm() <
            1e-7 * (1 + curve.evaluate(u, 3).norm()));
    }
  }
  CHECK_THROWS_AS(curve.evaluate(0, 4), InputError);
}

TEST_CASE("a curve holds cubics exactly and circles to the fourth order", "[fem][hermite_curve]") {
  const HermiteCurve cubic = interpolate({-1, 0.3, 0.5, 2}, [](double u) {
    return std::pair(Vec3(u * u * u, u * u - u, 2), Vec3(3 * u * u, 2 * u - 1, 0));
  });
  for (const double u : {-0.7, 0.1, 0.4, 1.1, 1.9}) {
    CHECK((cubic.evaluate(u) - Vec3(u * u * u, u * u - u, 2)).norm() < 1e-14);
    CHECK((cubic.evaluate(u, 2) - Vec3(6 * u, 2, 0)).norm() < 1e-12);
  }
  double previous = 0;
  for (const int segments : {4, 8, 16}) {
    const HermiteCurve circle = arc(2, pi, segments);
    double worst = 0;
    for (int i = 0; i <= 200; ++i)
      worst = std::max(worst, std::abs(circle.evaluate(circle.end() * i / 200).norm() - 2));
    if (previous > 0) CHECK(std::log2(previous / worst) == Approx(4).margin(0.2));
    previous = worst;
  }
}

TEST_CASE("length and curvature are those of straight lines and circles", "[fem][hermite_curve]") {
  const HermiteCurve line = interpolate({0, 1, 5}, [](double u) {
    return std::pair(Vec3(1 + 2 * u, 2 - u, 3 + 2 * u), Vec3(2, -1, 2));
  });
  CHECK(line.length() == Approx(15).epsilon(1e-14));
  CHECK(line.curvature(0.4) < 1e-14);
  // Not parametrised by arc length: the same line with an uneven parameter.
  const HermiteCurve uneven = interpolate(
      {0, 1}, [](double u) { return std::pair(Vec3(u + u * u, 0, 0), Vec3(1 + 2 * u, 0, 0)); });
  CHECK(uneven.length() == Approx(2).epsilon(1e-14));

  double length_before = 0, curvature_before = 0;
  for (const int segments : {8, 16, 32}) {
    const HermiteCurve circle = arc(3, 1.5 * pi, segments);
    const double length = std::abs(circle.length() - 4.5 * pi);
    double curvature = 0;
    for (int i = 0; i <= 300; ++i)
      curvature = std::max(curvature, std::abs(circle.curvature(circle.end() * i / 300) - 1.0 / 3));
    if (length_before > 0) {
      CHECK(std::log2(length_before / length) > 3.8);
      CHECK(std::log2(curvature_before / curvature) == Approx(2).margin(0.2));
    }
    length_before = length;
    curvature_before = curvature;
  }
  CHECK(length_before < 1e-4);
  // Curvature does not depend on the unit of the parameter.
  const HermiteCurve circle = arc(3, 1.5 * pi, 32);
  std::vector<double> faster = circle.parameters();
  for (double& u : faster) u /= 5;
  Points dofs = circle.dofs();
  for (int i = 0; i < circle.node_count(); ++i) dofs.row(circle.mesh().slope_out(i)) *= 5;
  const HermiteCurve other(CurveMesh(faster), dofs);
  CHECK(other.curvature(0.3) == Approx(circle.curvature(1.5)).epsilon(1e-12));
  CHECK(other.length() == Approx(circle.length()).epsilon(1e-12));
  // A constant curve has no curvature, instead of an infinite one.
  const HermiteCurve still({0, 1}, Points::Ones(2, 3), Points::Zero(2, 3));
  CHECK(still.length() == 0);
  CHECK(still.curvature(0.5) == 0);
}

TEST_CASE("the closest point is the closest point", "[fem][hermite_curve]") {
  for (unsigned seed = 10; seed < 14; ++seed) {
    const HermiteCurve curve = random_curve(seed, 5);
    Random random(seed);
    for (int trial = 0; trial < 40; ++trial) {
      const Vec3 p = Vec3(2, 0, 0) + 3 * random.point();
      const auto closest = curve.closest_point(p);
      CHECK(closest.u >= curve.start());
      CHECK(closest.u <= curve.end());
      CHECK(std::abs((curve.evaluate(closest.u) - p).norm() - closest.distance) < 1e-14);
      CHECK(closest.distance < distance_by_search(curve, p) + 1e-11);
    }
    for (int i = 0; i <= 50; ++i) {
      const double u = curve.start() + (curve.end() - curve.start()) * i / 50;
      CHECK(curve.closest_point(curve.evaluate(u)).distance < 1e-12);
    }
  }
  // Ends, and far away.
  const HermiteCurve line =
      interpolate({0, 1, 5}, [](double u) { return std::pair(Vec3(u, 0, 0), Vec3(1, 0, 0)); });
  CHECK(line.closest_point({-3, 4, 0}).distance == Approx(5).epsilon(1e-15));
  CHECK(line.closest_point({-3, 4, 0}).u == 0);
  CHECK(line.closest_point({9, 0, 3}).u == 5);
  CHECK(line.closest_point({2.5, 1e6, 0}).u == Approx(2.5).epsilon(1e-12));
}

TEST_CASE("the closest point is found from near the centre of curvature too",
          "[fem][hermite_curve]") {
  const HermiteCurve curve = interpolate({0, 1, 2, 3}, [](double u) {
    return std::pair(Vec3(std::cos(u), 1.05 * std::sin(u), 0.02 * u),
                     Vec3(-std::sin(u), 1.05 * std::cos(u), 0.02));
  });
  Random random(20);
  double excess = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3 p = 0.15 * random.point();
    excess = std::max(excess, curve.closest_point(p).distance - distance_by_search(curve, p));
  }
  CHECK(excess < 1e-11);
}

TEST_CASE("curves that are none are input errors", "[fem][hermite_curve]") {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  const Points two = Points::Zero(2, 3), three = Points::Zero(3, 3);
  CHECK_NOTHROW(HermiteCurve({0, 1}, two, two));
  CHECK_THROWS_AS(HermiteCurve({0}, Points::Zero(1, 3), Points::Zero(1, 3)), InputError);
  CHECK_THROWS_AS(HermiteCurve({}, Points::Zero(0, 3), Points::Zero(0, 3)), InputError);
  CHECK_THROWS_AS(HermiteCurve({0, 0}, two, two), InputError);
  CHECK_THROWS_AS(HermiteCurve({1, 0}, two, two), InputError);
  CHECK_THROWS_AS(HermiteCurve({0, 1}, three, two), InputError);
  CHECK_THROWS_AS(HermiteCurve({0, 1}, two, three), InputError);
  for (const double bad : {nan, inf}) {
    Points wrong = two;
    wrong(1, 2) = bad;
    CHECK_THROWS_AS(HermiteCurve({0, 1}, wrong, two), InputError);
    CHECK_THROWS_AS(HermiteCurve({0, 1}, two, wrong), InputError);
    CHECK_THROWS_AS(HermiteCurve({0, bad}, two, two), InputError);
  }
}
