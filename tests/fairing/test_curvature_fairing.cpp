// SPDX-License-Identifier: MPL-2.0
// Minimum curvature: points give circles, clamped ends give elasticas, three arcs give spheres, and
// the result is independent of unit, position and parameter.
#include "batten/fairing/curvature/curvature_fairing.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/fairing/minimum_variation/surface_curvature.h"
#include "batten/fem/surface_assembler.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/clamped_boundary.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

using std::numbers::pi;

CurvatureFairingOptions options_of(CurveFunctional functional, int segments,
                                   double tolerance = 1e-7) {
  CurvatureFairingOptions options;
  options.functional = functional;
  options.segments = segments;
  options.tolerance = tolerance;
  return options;
}

Vec3 direction(double degrees) {
  return {std::cos(degrees * pi / 180), std::sin(degrees * pi / 180), 0};
}

// `count` points per quarter of a circle in a plane, mapped by M.
std::vector<CurveThroughPoint> on_circle(int count, bool tangents, double radius = 1,
                                         const Vec3& centre = Vec3::Zero(),
                                         const Mat3& M = Mat3::Identity()) {
  std::vector<CurveThroughPoint> points;
  for (int i = 0; i < count; ++i) {
    points.push_back({centre + radius * (M * direction(90 * i))});
    if (tangents) points.back().tangent = 2.5 * (M * direction(90 * i + 90));
  }
  return points;
}

double radius_error(const QuinticCurve& curve, double radius = 1,
                    const Vec3& centre = Vec3::Zero()) {
  double error = 0;
  for (int i = 0; i < curve.segment_count(); ++i)
    for (int k = 0; k <= 16; ++k)
      error = std::max(error, std::abs((curve.evaluate({i, k / 16.0}) - centre).norm() - radius));
  return error;
}

Mat3 some_rotation() {
  return Eigen::AngleAxisd(1.1, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
}

// A planar curve by its angle: θ' = κ, κ'' = -κ³/2 (a rod of free length), from 0 over length L.
struct Elastica {
  Vec3 end;  // x, y, θ
  double energy = 0;
  std::vector<Vec3> points;
};

Elastica elastica(double angle, double kappa, double slope, double L) {
  using State = Eigen::Matrix<double, 6, 1>;  // x, y, θ, κ, κ', energy
  const auto f = [](const State& s) {
    State d;
    d << std::cos(s[2]), std::sin(s[2]), s[3], s[4], -0.5 * s[3] * s[3] * s[3], s[3] * s[3];
    return d;
  };
  State s;
  s << 0, 0, angle, kappa, slope, 0;
  Elastica result;
  constexpr int steps = 2000;
  const double h = L / steps;
  for (int i = 0; i < steps; ++i) {
    const State a = f(s), b = f(s + h / 2 * a), c = f(s + h / 2 * b), d = f(s + h * c);
    s += h / 6 * (a + 2 * b + 2 * c + d);
    result.points.emplace_back(s[0], s[1], 0);
  }
  result.end = s.head<3>();
  result.energy = s[5];
  return result;
}

// Shooting method from (0, 0) at angle `from` to `end` (x, y, θ), with Newton's method.
Elastica shot(double from, const Vec3& end, Vec3 guess) {
  for (int step = 0; step < 30; ++step) {
    const Vec3 miss = elastica(from, guess[0], guess[1], guess[2]).end - end;
    Mat3 J;
    for (int k = 0; k < 3; ++k) {
      Vec3 aside = guess;
      aside[k] += 1e-6;
      J.col(k) = (elastica(from, aside[0], aside[1], aside[2]).end - end - miss) / 1e-6;
    }
    guess -= J.lu().solve(miss);
  }
  return elastica(from, guess[0], guess[1], guess[2]);
}

}  // namespace

TEST_CASE("quintic segments hold fifth degrees, and cubics follow them within a tolerance",
          "[fairing][curves]") {
  const auto p = [](double u, int order) {
    const double c[4] = {u * u * u * u * u - 2 * u * u, 5 * u * u * u * u - 4 * u,
                         20 * u * u * u - 4, 60 * u * u};
    return Vec3(c[order], order == 0 ? 3 * u : (order == 1 ? 3.0 : 0.0), -c[order]);
  };
  const std::vector<double> u = {-0.5, 0.25, 0.5, 1.75};
  Points dofs(12, 3);
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) dofs.row(3 * i + k) = p(u[i], k);
  const QuinticCurve curve(u, dofs);
  for (const double at : {-0.5, -0.1, 0.3, 0.5, 1.1, 1.75})
    for (int order = 0; order < 4; ++order)
      CHECK((curve.evaluate(at, order) - p(at, order)).norm() < 1e-11);
  for (const double tolerance : {1e-2, 1e-5, 1e-8}) {
    const HermiteCurve cubics = curve.cubics(tolerance);
    double error = 0;
    for (int k = 0; k <= 5000; ++k) {
      const double at = -0.5 + 2.25 * k / 5000;
      error = std::max(error, (cubics.evaluate(at) - p(at, 0)).norm());
    }
    CHECK(error <= tolerance);
    CHECK(error > 0.05 * tolerance);  // no more segments than necessary
  }
  CHECK_THROWS_AS(curve.cubics(0), InputError);
  CHECK_THROWS_AS(QuinticCurve(u, dofs.topRows(11)), InputError);
}

TEST_CASE("a build without Ceres reports that", "[fairing][curves]") {
  if (have_curvature_fairing()) return;
  CHECK_THAT(error_message([] {
               minimum_curvature_curve(on_circle(4, true), true,
                                       options_of(CurveFunctional::Variation, 8));
             }),
             Contains("built without Ceres"));
}

TEST_CASE("four points and tangents of a circle give the circle, with order 6 or more",
          "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  double before = 0;
  for (const int segments : {4, 8, 16, 32}) {
    const auto c = minimum_curvature_curve(on_circle(4, true), true,
                                           options_of(CurveFunctional::Variation, segments, 1e-8));
    const double error = radius_error(c.quintic);
    INFO(segments << " segments: " << error);
    CHECK(c.converged);
    CHECK(c.max_residual < 1e-15);
    CHECK(c.deviation <= 1e-8);
    CHECK(c.functional < 1e-5 * c.start_functional);
    if (segments == 16) CHECK(error < 1e-9);
    if (before > 0) CHECK(error < std::max(std::pow(0.5, 6) * before, 1e-12));
    for (int k = 0; k < 1000; ++k) {
      const double u = c.curve.end() * k / 1000;
      CHECK(std::abs(c.curve.evaluate(u).norm() - 1) <= 1.02 * error + 1e-8);
    }
    before = error;
  }
}

TEST_CASE("a circle comes out in any plane, far away, of any size, and from points of an arc alone",
          "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const Vec3 centre(1e4, -2e4, 5e3);
  const auto far = minimum_curvature_curve(on_circle(4, true, 3, centre, some_rotation()), true,
                                           options_of(CurveFunctional::Variation, 16));
  CHECK(far.converged);
  CHECK(far.max_residual < 1e-12);
  CHECK(radius_error(far.quintic, 3, centre) < 3e-9);
  for (const double radius : {1e-3, 1.0, 1e3}) {
    const auto arc =
        minimum_curvature_curve(on_circle(4, false, radius), false,
                                options_of(CurveFunctional::Variation, 12, 1e-7 * radius));
    CHECK(arc.converged);
    CHECK(radius_error(arc.quintic, radius) < 1e-7 * radius);
    CHECK(arc.curve.length() == Approx(1.5 * pi * radius).epsilon(1e-7));
  }
}

TEST_CASE("the unit does not matter", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const std::vector<Vec3> given = {{0, 0, 0}, {1, 0.7, 0.2}, {2.2, -0.1, 0.5}, {3, 0.4, 0}};
  for (const auto functional : {CurveFunctional::Energy, CurveFunctional::Variation}) {
    std::vector<CurveThroughPoint> m, mm;
    for (const Vec3& p : given) {
      m.push_back({p});
      mm.push_back({1000 * p});
    }
    m[0].tangent = mm[0].tangent = Vec3(0, 1, 0);
    const auto a = minimum_curvature_curve(m, false, options_of(functional, 12, 1e-6));
    const auto b = minimum_curvature_curve(mm, false, options_of(functional, 12, 1e-3));
    CHECK(a.converged);
    CHECK(b.converged);
    const double unit = functional == CurveFunctional::Energy ? 1e3 : 1e9;
    CHECK(b.functional * unit == Approx(a.functional).epsilon(1e-9));
    for (int k = 0; k <= 100; ++k)
      CHECK(a.curve.closest_point(b.curve.evaluate(b.curve.end() * k / 100) / 1000).distance <
            4e-6);
  }
}

TEST_CASE("a rod clamped at both ends is the elastica that shooting finds", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const std::vector<CurveThroughPoint> ends = {{Vec3(0, 0, 0), direction(70)},
                                               {Vec3(1, 0.2, 0), direction(20)}};
  const auto rod =
      minimum_curvature_curve(ends, false, options_of(CurveFunctional::Energy, 16, 1e-8));
  CHECK(rod.converged);
  CHECK(rod.functional < rod.start_functional);
  const Elastica exact = shot(70 * pi / 180, {1, 0.2, 20 * pi / 180}, {-3, 5, rod.curve.length()});
  CHECK((exact.end - Vec3(1, 0.2, 20 * pi / 180)).norm() < 1e-12);
  CHECK(rod.functional == Approx(exact.energy).epsilon(1e-9));
  double error = 0;
  for (size_t i = 0; i < exact.points.size(); i += 50)
    error = std::max(error, rod.curve.closest_point(exact.points[i]).distance);
  CHECK(error < 1e-6);
}

TEST_CASE("half of the rectangular elastica", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  // Width 1, from its vertical start to its top: height √2/c, energy c².
  const double k = std::sqrt(0.5), c = 2 * (2 * std::comp_ellint_2(k) - std::comp_ellint_1(k));
  const auto half = minimum_curvature_curve(
      {{Vec3(0, 0, 0), direction(90)}, {Vec3(0.5, std::sqrt(2.0) / c, 0), direction(0)}}, false,
      options_of(CurveFunctional::Energy, 8));
  CHECK(half.functional == Approx(c * c).epsilon(1e-8));
  CHECK(half.quintic.evaluate(0, 2).norm() < 1e-3);  // an inflection
  CHECK(half.curve.length() == Approx(std::comp_ellint_1(k) / c).epsilon(1e-6));
}

TEST_CASE("a rod that has to turn back grows without bound unless length costs",
          "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const std::vector<CurveThroughPoint> ends = {{Vec3(0, 0, 0), direction(110)},
                                               {Vec3(1, 0, 0), direction(-110)}};
  auto options = options_of(CurveFunctional::Energy, 16);
  CHECK_THROWS_AS(minimum_curvature_curve(ends, false, options), NoSolutionError);
  options.length_weight = 2;
  const auto bounded = minimum_curvature_curve(ends, false, options);
  CHECK(bounded.converged);
  options.length_weight = 20;
  CHECK(minimum_curvature_curve(ends, false, options).curve.length() < bounded.curve.length());
}

TEST_CASE("ends of a helix give a space curve that varies no more than the helix",
          "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const double pitch = 0.4, turn = 0.75 * pi, speed2 = 1 + pitch * pitch;
  std::vector<CurveThroughPoint> points;
  for (const double t : {0.0, 0.5 * turn, turn})
    points.push_back(
        {Vec3(std::cos(t), std::sin(t), pitch * t), Vec3(-std::sin(t), std::cos(t), pitch)});
  const double kappa = 1 / speed2, tau = pitch / speed2;
  const double own = kappa * kappa * tau * tau * std::sqrt(speed2) * turn;
  const auto c = minimum_curvature_curve(points, false, options_of(CurveFunctional::Variation, 12));
  CHECK(c.converged);
  CHECK(c.functional < own);
  CHECK(c.functional > 0.1 * own);

  // The first variation is zero for every free dof.
  const auto slopes = [](const QuinticCurve& curve) {
    double sum = 0;
    for (int node = 0; node < curve.node_count(); ++node)
      for (int kind = node % 6 == 0 ? 2 : 0; kind < 3; ++kind)
        for (int x = 0; x < 3; ++x) {
          double value[2];
          for (const int side : {0, 1}) {
            Points dofs = curve.dofs();
            dofs(3 * node + kind, x) += side ? 1e-5 : -1e-5;
            value[side] =
                curvature_functional({curve.parameters(), dofs}, CurveFunctional::Variation);
          }
          sum += std::pow((value[1] - value[0]) / 2e-5, 2);
        }
    return std::sqrt(sum);
  };
  Points moved = c.quintic.dofs();
  moved(10, 0) += 1e-2;
  CHECK(slopes(c.quintic) < 1e-5 * slopes({c.quintic.parameters(), moved}));
}

TEST_CASE("evenness and quadrature do not show in the shape", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const std::vector<CurveThroughPoint> points = {
      {Vec3(0, 0, 0), direction(60)}, {Vec3(0.4, 0.5, 0.1)}, {Vec3(1.3, 0.2, 0), direction(-30)}};
  for (const auto functional : {CurveFunctional::Energy, CurveFunctional::Variation}) {
    auto options = options_of(functional, 24, 1e-8);
    const auto weak = minimum_curvature_curve(points, false, options);
    options.parametrization_weight *= 100;
    const auto strong = minimum_curvature_curve(points, false, options);
    CHECK(strong.functional == Approx(weak.functional).epsilon(1e-7));
    for (int k = 0; k <= 50; ++k)
      CHECK(weak.curve.closest_point(strong.curve.evaluate(strong.curve.end() * k / 50)).distance <
            2e-6);
    CHECK(curvature_functional(weak.quintic, functional, 40) ==
          Approx(curvature_functional(weak.quintic, functional, 8)).epsilon(1e-9));
    double slowest = 1, fastest = 1;
    for (int k = 0; k <= 200; ++k) {
      const double speed = weak.curve.evaluate(weak.curve.end() * k / 200, 1).norm();
      slowest = std::min(slowest, speed);
      fastest = std::max(fastest, speed);
    }
    CHECK(fastest - slowest < 2e-3);
  }
}

TEST_CASE("a wavy curve is faired between its constraints", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  Random random(7);
  std::vector<double> u;
  Points X(17, 3), D(17, 3);
  std::vector<CurveSpring> springs;
  for (int i = 0; i <= 16; ++i) {
    u.push_back(0.25 * i);
    X.row(i) = Vec3(0.25 * i, std::sin(0.25 * i), 0) + 0.01 * random.point();
    D.row(i) = Vec3(1, std::cos(0.25 * i), 0);
    springs.push_back({X.row(i).transpose(), 1});
  }
  const HermiteCurve wavy(u, X, D);
  const std::vector<FixedCurvePoint> holds = {{0, true, true}, {2, true, false}, {4, true, false}};
  double nearer = 0, fairer = 1e300;
  for (const double stiffness : {1e6, 1e4, 1e2}) {
    for (auto& spring : springs) spring.stiffness = stiffness;
    const auto c =
        fair_curvature(wavy, holds, springs, options_of(CurveFunctional::Energy, 16, 1e-6));
    CHECK(c.converged);
    CHECK(c.functional < c.start_functional);
    CHECK(c.functional < fairer);
    fairer = c.functional;
    CHECK(c.max_residual < 1e-12);
    for (size_t i = 0; i < holds.size(); ++i)
      CHECK(c.curve.evaluate(c.parameters[i]) == wavy.evaluate(holds[i].u));
    double away = 0;
    for (const auto& spring : springs) away += c.curve.closest_point(spring.point).distance;
    CHECK(away > nearer);
    nearer = away;
  }
  // Only the fixed points matter: the shape between them is discarded.
  const auto free = fair_curvature(wavy, holds, {}, options_of(CurveFunctional::Energy, 16, 1e-6));
  CHECK(free.functional < fairer);
}

TEST_CASE("curvature fairing refuses invalid input", "[fairing][curves]") {
  if (!have_curvature_fairing()) return;
  const auto said = [](std::vector<CurveThroughPoint> points, bool closed,
                       const CurvatureFairingOptions& o) {
    return error_message([&] { minimum_curvature_curve(points, closed, o); });
  };
  const auto good = options_of(CurveFunctional::Variation, 8);
  const auto circle = on_circle(4, true);
  CHECK_THAT(said({{Vec3(0, 0, 0)}}, false, good), Contains("found 1 points"));
  CHECK_THAT(said({{Vec3(0, 0, 0)}, {Vec3(1, 0, 0)}}, true, good), Contains("three"));
  CHECK_THAT(said({{Vec3(0, 0, 0)}, {Vec3(1, 0, 0)}, {Vec3(1, 0, 0)}}, false, good),
             Contains("point 3 coincides with the point before"));
  CHECK_THAT(said({{Vec3(0, 0, 0), Vec3(0, 0, 0)}, {Vec3(1, 0, 0)}}, false, good),
             Contains("point 1 has a tangent of length zero"));
  CHECK_THAT(said({{Vec3(0, std::nan(""), 0)}, {Vec3(1, 0, 0)}}, false, good),
             Contains("not finite"));
  auto bad = good;
  bad.segments = 3;
  CHECK_THAT(said(circle, true, bad), Contains("3 segments, expected at least 4"));
  for (const double tolerance : {0.0, -1.0, std::nan("")}) {
    bad = good;
    bad.tolerance = tolerance;
    CHECK_THAT(said(circle, true, bad), Contains("tolerance"));
  }
  bad = good;
  bad.parametrization_weight = 0;
  CHECK_THAT(said(circle, true, bad), Contains("parametrization_weight"));

  const HermiteCurve line({0, 1, 2}, (Points(3, 3) << 0, 0, 0, 1, 0, 0, 2, 1, 0).finished(),
                          Points::Ones(3, 3));
  const auto unfair = [&](const HermiteCurve& curve, const std::vector<FixedCurvePoint>& holds,
                          const std::vector<CurveSpring>& springs) {
    return error_message([&] { fair_curvature(curve, holds, springs, good); });
  };
  CHECK_THAT(unfair(line, {{0}}, {}), Contains("two fixed points or two springs"));
  CHECK_THAT(unfair(line, {{0}, {3}}, {}), Contains("u = 3, expected 0 to 2"));
  CHECK_THAT(unfair(line, {{0}, {1}, {1 + 1e-12}}, {}), Contains("two fixed points"));
  CHECK_THAT(unfair(line, {{0}, {2}}, {{Vec3(0, 0, 0), 0}}), Contains("stiffness above 0"));
  const HermiteCurve bent(CurveMesh({0, 1, 2}, false, {1}), Points::Random(7, 3));
  CHECK_THAT(unfair(bent, {{0}, {2}}, {}), Contains("corners"));
}

namespace {

// n² triangles of an equilateral domain, as the octant of the unit sphere between three quarter
// circles, with constraints on these and on the normals along them.
struct Octant {
  std::shared_ptr<const ParametricMesh> mesh;
  ConstraintSet rows{0};

  Octant(int n, TriangleElement kind) {
    const Vec2 corner[3] = {{0, 0}, {1, 0}, {0.5, std::sqrt(0.75)}};
    std::vector<Vec2> vertices;
    std::vector<ParametricMesh::Triangle> triangles;
    const auto at = [&](int i, int j) { return j * (n + 1) - j * (j - 1) / 2 + i; };
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i + j <= n; ++i) {
        vertices.push_back((1.0 * i * corner[1] + 1.0 * j * corner[2]) / n);
        if (i + j < n) triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j < n - 1) triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    mesh = std::make_shared<ParametricMesh>(vertices, triangles);
    rows = ConstraintSet(DofMap(*mesh).count());
    SurfaceConstraints shape(*mesh, kind, rows);
    for (int side = 0; side < 3; ++side) {
      const Vec3 a = Vec3::Unit(side), b = Vec3::Unit((side + 1) % 3);
      std::vector<int> run, edges;
      std::vector<double> angle;
      Points X(n + 1, 3), D(n + 1, 3);
      for (int k = 0; k <= n; ++k) {
        run.push_back(side == 0 ? at(k, 0) : (side == 1 ? at(n - k, k) : at(0, n - k)));
        angle.push_back(0.5 * pi * k / n);
        X.row(k) = std::cos(angle[k]) * a + std::sin(angle[k]) * b;
        D.row(k) = std::cos(angle[k]) * b - std::sin(angle[k]) * a;
        if (k > 0) edges.push_back(mesh->edge_between(run[k - 1], run[k]));
      }
      shape.curve("arc", run, angle, {angle, X, D}, corner[(side + 1) % 3] - corner[side]);
      const auto normal = [&](int edge, double s) -> Vec3 {
        const Vec2 p = (1 - s) * mesh->vertices()[mesh->edges()[edge].low] +
                       s * mesh->vertices()[mesh->edges()[edge].high];
        const double along = 0.5 * pi * (p - corner[side]).norm();
        return std::cos(along) * a + std::sin(along) * b;
      };
      shape.varying_normal("normals", edges, normal, true);
    }
  }

  Surface least_bending(TriangleElement kind) const {
    return {mesh, kind,
            solve_constrained(rows, SurfaceAssembler(*mesh, kind).stiffness(SurfaceStiffness{}),
                              Points::Zero(rows.dof_count(), 3))};
  }
};

double sphere_error(const Surface& surface) {
  double error = 0;
  for (const Location& where : tessellate(surface.mesh(), 5).points)
    error = std::max(error, std::abs(surface.position(where).norm() - 1));
  return error;
}

// An asymmetric bent surface.
Surface bent_surface(TriangleElement kind, double unit = 1, const Mat3& M = Mat3::Identity(),
                     const Vec3& by = Vec3::Zero()) {
  return interpolated(std::make_shared<ParametricMesh>(perturbed_square(3, 5)), kind,
                      [&](const Vec2& p) {
                        const double u = p.x(), v = p.y();
                        SurfaceJet j;
                        j.x = unit * (M * Vec3(u + 0.2 * u * v, v, u * u - 0.7 * u * v)) + by;
                        j.x_u = unit * (M * Vec3(1 + 0.2 * v, 0, 2 * u - 0.7 * v));
                        j.x_v = unit * (M * Vec3(0.2 * u, 1, -0.7 * u));
                        return j;
                      });
}

}  // namespace

TEST_CASE("three quarter circles with their normals give the sphere, with order 4",
          "[fairing][curves]") {
  SurfaceCurvatureOptions options;
  options.tolerance = 1e-8;
  double before = 0, functional_before = 0;
  for (const int n : {3, 6, 12}) {
    const Octant octant(n, TriangleElement::HCT);
    const Surface start = octant.least_bending(TriangleElement::HCT);
    const SurfaceCurvatureResult result = fair_curvature(start, octant.rows, options);
    const double error = sphere_error({octant.mesh, TriangleElement::HCT, result.dofs});
    const double functional = std::abs(result.functional - pi);  // twice the octant's area
    INFO(n << ": distance " << error << ", functional " << functional << ", iterations "
           << result.iterations);
    CHECK(result.max_residual < 1e-14);
    CHECK(result.start_functional > pi + 0.05);
    CHECK(sphere_error(start) > 0.015);
    if (before > 0) {
      CHECK(error < std::pow(0.5, 3.6) * before);
      CHECK(functional < std::pow(0.5, 3.6) * functional_before);
    }
    before = error;
    functional_before = functional;
  }
  CHECK(before < 2e-6);
  CHECK(functional_before < 1e-5);
}

TEST_CASE("both triangles find the sphere, and evenness does not show", "[fairing][curves]") {
  double error[2][2];
  for (const auto kind : kBothElements)
    for (const int strong : {0, 1}) {
      const Octant octant(4, kind);
      SurfaceCurvatureOptions options;
      options.parametrization_weight = strong ? 3e-2 : 1e-2;
      const SurfaceCurvatureResult result =
          fair_curvature(octant.least_bending(kind), octant.rows, options);
      CHECK(result.converged);
      error[kind == TriangleElement::Z12][strong] = sphere_error({octant.mesh, kind, result.dofs});
    }
  CHECK(error[0][0] < 1e-4);
  CHECK(error[1][0] == Approx(error[0][0]).epsilon(0.1));
  CHECK(error[0][1] == Approx(error[0][0]).epsilon(0.1));
}

TEST_CASE("the same bits again, on one thread as on two", "[fairing][curves]") {
  const Octant octant(3, TriangleElement::HCT);
  const Surface start = octant.least_bending(TriangleElement::HCT);
  Points dofs[2];
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    dofs[threads - 1] = fair_curvature(start, octant.rows).dofs;
  }
  set_thread_count(0);
  CHECK(dofs[0] == dofs[1]);
  if (!have_curvature_fairing()) return;
  const auto curve = [] {
    return minimum_curvature_curve(on_circle(3, true), false,
                                   options_of(CurveFunctional::Energy, 8))
        .quintic.dofs();
  };
  CHECK(curve() == curve());
}

TEST_CASE("the functional of a surface depends neither on position nor on size nor on side",
          "[fairing][curves]") {
  for (const auto kind : kBothElements) {
    const double here = curvature_functional(bent_surface(kind));
    CHECK(here > 1);
    CHECK(curvature_functional(bent_surface(kind, 1, some_rotation(), {3, -1, 2})) ==
          Approx(here).epsilon(1e-11));
    CHECK(curvature_functional(bent_surface(kind, 1000)) == Approx(here).epsilon(1e-12));
    CHECK(curvature_functional(bent_surface(kind, 1, -Mat3::Identity())) ==
          Approx(here).epsilon(1e-12));
    // As Surface and Curvatures compute it at the same points.
    const Surface surface = bent_surface(kind);
    const TriangleRule& rule = C1Triangle::default_quadrature(kind);
    double sum = 0;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t)
      for (long p = 0; p < rule.weights.size(); ++p) {
        const SurfaceJet jet = surface.jet({t, rule.L.row(p).transpose()});
        const Curvatures c = curvatures(jet);
        sum += rule.weights[p] * surface.mesh().shape(t).area * jet.area_vector().norm() *
               (c.k1 * c.k1 + c.k2 * c.k2);
      }
    CHECK(here == Approx(sum).epsilon(1e-12));
  }
}

TEST_CASE("the gradient of a surface's functional is that of differences", "[fairing][curves]") {
  for (const auto kind : kBothElements) {
    const Surface surface = bent_surface(kind);
    Points gradient;
    curvature_functional(surface, &gradient);
    const auto at = [&](int dof, int x, double by) {
      Points q = surface.dofs();
      q(dof, x) += by;
      return curvature_functional({surface.shared_mesh(), kind, q});
    };
    double error = 0;
    for (int dof = 0; dof < surface.dof_map().count(); dof += 10)
      for (int x = 0; x < 3; ++x) {
        constexpr double h = 1e-4;
        const double slope =
            (8 * (at(dof, x, h) - at(dof, x, -h)) - (at(dof, x, 2 * h) - at(dof, x, -2 * h))) /
            (12 * h);
        error = std::max(error, std::abs(slope - gradient(dof, x)));
      }
    CHECK(error < 1e-7 * gradient.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a plane stays a plane, and a bump between flat clamped edges becomes one",
          "[fairing][curves]") {
  const auto mesh = std::make_shared<ParametricMesh>(perturbed_square(4, 3));
  const Surface flat = interpolated(mesh, TriangleElement::HCT, [](const Vec2& p) {
    SurfaceJet j;
    j.x = Vec3(1e3 + p.x(), p.y(), 2 * p.x());
    j.x_u = Vec3(1, 0, 2);
    j.x_v = Vec3(0, 1, 0);
    return j;
  });
  ConstraintSet rim(flat.dof_map().count());
  const ConstraintSet zero = clamped_boundary(*mesh);
  for (const auto& row : zero.constraints())
    rim.fix("rim", row.entries[0].dof, flat.dofs().row(row.entries[0].dof));
  const SurfaceCurvatureResult same = fair_curvature(flat, rim);
  CHECK(same.converged);
  CHECK(same.functional < 1e-20);
  CHECK((same.dofs - flat.dofs()).norm() < 1e-9);

  Points bumped = flat.dofs();
  Random random(1);
  for (int v = 0; v < mesh->vertex_count(); ++v)
    bumped(flat.dof_map().vertex(v), 1) += 0.02 * random();
  for (int v = 0; v < mesh->vertex_count(); ++v)
    bumped(flat.dof_map().vertex(v), 2) += 0.02 * random();
  const SurfaceCurvatureResult result = fair_curvature({mesh, TriangleElement::HCT, bumped}, rim);
  CHECK(result.start_functional > 0.01);
  CHECK(result.functional < 1e-12);
  const VecX off = result.dofs.col(2) - 2 * result.dofs.col(0);
  for (int v = 0; v < mesh->vertex_count(); ++v)
    CHECK(std::abs(off[flat.dof_map().vertex(v)] + 2e3) < 1e-6);
}

TEST_CASE("curvature fairing of surfaces refuses invalid input", "[fairing][curves]") {
  const Octant octant(2, TriangleElement::HCT);
  const Surface start = octant.least_bending(TriangleElement::HCT);
  SurfaceCurvatureOptions bad;
  bad.parametrization_weight = 0;
  CHECK_THAT(error_message([&] { fair_curvature(start, octant.rows, bad); }), Contains("above 0"));
  CHECK_THAT(error_message([&] { fair_curvature(start, ConstraintSet(7), {}); }),
             Contains("7 dofs"));
  CHECK_THROWS_AS(fair_curvature(start, ConstraintSet(start.dof_map().count())), NoSolutionError);
  Points q = start.dofs();
  q(3, 0) = std::nan("");
  CHECK_THAT(error_message([&] {
               fair_curvature({octant.mesh, TriangleElement::HCT, q}, octant.rows);
             }),
             Contains("not finite"));
  CHECK_THAT(
      error_message([&] {
        fair_curvature({octant.mesh, TriangleElement::HCT, Points::Zero(q.rows(), 3)}, octant.rows);
      }),
      Contains("area zero"));
}
