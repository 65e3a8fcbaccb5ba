// SPDX-License-Identifier: MPL-2.0
// The fairness report and curvature combs for curves with known curvature.
#include <cmath>
#include <numbers>

#include "batten/fairing/curves/curve_fit.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;

namespace {

using std::numbers::pi;

HermiteCurve sampled(int segments, double from, double to,
                     const std::function<Vec3(double, int)>& x, bool closed = false) {
  std::vector<double> u;
  for (int i = 0; i <= segments; ++i) u.push_back(from + (to - from) * i / segments);
  const CurveMesh mesh(u, closed);
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < mesh.node_count(); ++i) {
    dofs.row(mesh.position_dof(i)) = x(u[i], 0);
    dofs.row(mesh.slope_out(i)) = x(u[i], 1);
  }
  return {mesh, dofs};
}

Vec3 circle(double t, int order) {
  return 3 * Vec3(std::cos(t + order * pi / 2), std::sin(t + order * pi / 2), 0);
}

Vec3 ellipse(double t, int order) {
  return {3 * std::cos(t + order * pi / 2), std::sin(t + order * pi / 2), 0};
}

}  // namespace

TEST_CASE("a circle has constant curvature, no extrema, no inflections", "[fairing][fairness]") {
  double before = 0;
  for (const int n : {16, 32, 64}) {
    const Fairness f = fairness(sampled(n, 0, 2 * pi, circle, true));
    CHECK(f.length == Approx(6 * pi).epsilon(1e-4));
    CHECK(f.bending == Approx(2 * pi / 3).epsilon(1e-3));
    const double off = f.variation;
    if (before > 0) CHECK(std::log2(before / off) > 1.8);  // κ' is of order h for a C1 cubic
    before = off;
    CHECK(f.largest_curvature == Approx(1 / 3.0).epsilon(0.02));
    CHECK(f.inflections == 0);
  }
}

TEST_CASE("an ellipse has four extrema, a figure of eight two inflections", "[fairing][fairness]") {
  const auto integral = [](const auto& f) {
    double sum = 0;
    const int n = 4000;
    for (int i = 0; i < n; ++i) sum += f(2 * pi * (i + 0.5) / n) * 2 * pi / n;
    return sum;
  };
  const Fairness f = fairness(sampled(256, 0, 2 * pi, ellipse, true));
  const auto speed = [](double t) { return ellipse(t, 1).norm(); };
  const auto curvature = [&](double t) { return 3 / std::pow(speed(t), 3); };
  const auto change = [&](double t) {  // dκ/dt
    const double h = 1e-5;
    return (curvature(t + h) - curvature(t - h)) / (2 * h);
  };
  CHECK(f.bending == Approx(integral([&](double t) {
                       return std::pow(curvature(t), 2) * speed(t);
                     })).epsilon(1e-3));
  CHECK(f.variation == Approx(integral([&](double t) {
                         return std::pow(change(t), 2) / speed(t);
                       })).epsilon(2e-2));
  CHECK(f.extrema == 4);
  CHECK(f.inflections == 0);
  const auto eight = [](double t, int order) -> Vec3 {
    const double s = std::pow(2.0, order);
    return {std::sin(t + order * pi / 2), s * 0.5 * std::sin(2 * t + order * pi / 2), 0};
  };
  const Fairness g = fairness(sampled(200, 0.1, 0.1 + 2 * pi, eight, true));
  CHECK(g.inflections == 2);
  // Also in space: the counts do not depend on the plane.
  const Mat3 rotation = Eigen::AngleAxisd(2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Fairness turned = fairness(sampled(
      200, 0.1, 0.1 + 2 * pi, [&](double t, int o) { return Vec3(rotation * eight(t, o)); }, true));
  CHECK(turned.inflections == 2);
  CHECK(turned.extrema == g.extrema);
  CHECK(turned.variation == Approx(g.variation).epsilon(1e-9));
}

TEST_CASE("a straight line is fair, a wavy one is counted wave by wave, corners are left out",
          "[fairing][fairness]") {
  const Fairness straight = fairness(sampled(7, 0, 1, [](double t, int o) {
    return o == 0 ? Vec3(t, 2 * t, 1e6 + 3 * t) : Vec3(1, 2, 3);
  }));
  CHECK(straight.extrema == 0);
  CHECK(straight.inflections == 0);
  const Fairness wavy = fairness(sampled(400, 0, 1, [](double t, int o) {
    const double w = 14 * pi;
    return o == 0 ? Vec3(t, 0.01 * std::sin(w * t), 0) : Vec3(1, 0.01 * w * std::cos(w * t), 0);
  }));
  CHECK(wavy.extrema == 14);
  CHECK(wavy.inflections == 13);
  FitOptions options;
  options.tolerance = 1e-9;
  options.corners = {{1, 2}};
  const Fairness house =
      fairness(fit_points("house", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, options).curve);
  CHECK(house.bending < 1e-12);
  CHECK(house.largest_jump < 1e-9);
}

TEST_CASE("corners cut the counts: a square of four arcs has no extrema and no inflections",
          "[fairing][fairness]") {
  // Arcs that bulge outwards, or inwards: the curvature vector changes its direction at every
  // corner.
  for (const double bulge : {0.3, -0.3}) {
    std::vector<double> u;
    const int per_side = 8;
    for (int i = 0; i <= 4 * per_side; ++i) u.push_back(i);
    const CurveMesh mesh(u, true, {0, per_side, 2 * per_side, 3 * per_side});
    Points dofs(mesh.dof_count(), 3);
    const Vec3 corner[5] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 0}};
    for (int s = 0; s < mesh.segment_count(); ++s) {
      const Vec3 a = corner[s / per_side], side = corner[s / per_side + 1] - a,
                 out = side.cross(Vec3::UnitZ());
      const auto dof = mesh.segment_dofs(s);
      for (const int end : {0, 1}) {
        const double x = static_cast<double>(s % per_side + end) / per_side;
        dofs.row(dof[2 * end]) = a + x * side + bulge * x * (1 - x) * out;
        dofs.row(dof[2 * end + 1]) = (side + bulge * (1 - 2 * x) * out) / per_side;
      }
    }
    const Fairness f = fairness({mesh, dofs});
    CHECK(f.inflections == 0);
    CHECK(f.extrema == 4);  // the vertex of each parabola
    CHECK(f.largest_jump < 1e-9);
  }
}

TEST_CASE("a jump of curvature is reported, and a C2 curve has none", "[fairing][fairness]") {
  const HermiteCurve bent({0, 1, 2}, (Points(3, 3) << 0, 0, 0, 1, 0, 0, 2, 0.5, 0).finished(),
                          (Points(3, 3) << 1, 0, 0, 1, 0, 0, 1, 1, 0).finished());
  // Segment one is straight, segment two has X''(0) = (0, 1, 0) at speed 1.
  CHECK(fairness(bent).largest_jump == Approx(bent.evaluate({1, 0}, 2).norm()).epsilon(1e-12));
  std::vector<Vec3> points;
  for (int i = 0; i < 30; ++i) points.push_back(circle(0.1 * i, 0));
  const Fairness given = fairness(interpolating_spline("arc", points));
  CHECK(given.largest_jump < 1e-9);
}

TEST_CASE("the teeth of a comb point away from the centre and are as long as the curvature",
          "[fairing][fairness]") {
  const HermiteCurve curve = sampled(64, 0, 2 * pi, circle, true);
  const auto comb = curvature_comb(curve, 128);
  CHECK(comb.size() >= 128);
  for (const CurvatureCombSample& tooth : comb) {
    CHECK(tooth.curvature == Approx(1 / 3.0).epsilon(1e-2));
    CHECK(tooth.outward.dot(tooth.point.normalized()) == Approx(1).epsilon(1e-3));
    CHECK((curve.evaluate(tooth.u) - tooth.point).norm() < 1e-12);
  }
}
