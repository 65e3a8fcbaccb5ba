// SPDX-License-Identifier: MPL-2.0
// Recognition of primitives in any position, orientation and unit, with their dimensions, and of
// nothing else.
#include "batten/skinning/surfaces/fitted_primitive.h"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

using std::numbers::pi;
using Kind = FittedPrimitive::Kind;

/// Positions and normals of a patch x(s, t) over a rectangle.
struct Patch {
  Points x, n;
};
Patch patch(const std::function<Vec3(double, double)>& x, double s0, double s1, double t0,
            double t1) {
  constexpr int count = 24;
  constexpr double step = 1e-5;
  Patch made{Points(count * count, 3), Points(count * count, 3)};
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const double s = s0 + (s1 - s0) * i / (count - 1), t = t0 + (t1 - t0) * j / (count - 1);
      made.x.row(i * count + j) = x(s, t);
      made.n.row(i * count + j) =
          (x(s + step, t) - x(s - step, t)).cross(x(s, t + step) - x(s, t - step)).normalized();
    }
  return made;
}

/// The patch rotated, translated, in another unit.
Patch placed(Patch p, double unit) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  p.x = unit * ((p.x * turn.transpose()).rowwise() + Vec3(30, -7, 12).transpose());
  p.n = p.n * turn.transpose();
  return p;
}
Vec3 placed(const Vec3& x, double unit) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  return unit * (turn * x + Vec3(30, -7, 12));
}

FittedPrimitive measured(const Patch& p, double tolerance) {
  return fit_primitive(p.x, p.n, tolerance);
}

Vec3 on_cylinder(double s, double t) { return {2 * std::cos(s), 2 * std::sin(s), t}; }
Vec3 on_sphere(double s, double t) {
  return 2 * Vec3(std::cos(s) * std::cos(t), std::sin(s) * std::cos(t), std::sin(t));
}
Vec3 on_cone(double s, double t) {
  const double r = 1 + t * std::tan(0.3);
  return {r * std::cos(s), r * std::sin(s), t};
}
Vec3 on_torus(double s, double t) {
  const double r = 3 + std::cos(t);
  return {r * std::cos(s), r * std::sin(s), std::sin(t)};
}

}  // namespace

TEST_CASE("primitives are found with their frames, in any position and unit",
          "[skinning][surfaces]") {
  for (const double unit : {1.0, 1e-3, 1e3}) {
    CAPTURE(unit);
    const double tolerance = 1e-4 * unit, hair = 1e-8 * unit;
    const FittedPrimitive plane = measured(
        placed(patch([](double s, double t) { return Vec3(s, 2 * t, 0); }, 0, 1, 0, 2), unit),
        tolerance);
    CHECK(plane.kind == Kind::Plane);
    CHECK(plane.deviation < hair);
    CHECK(std::abs(plane.distance(placed(Vec3(5, 5, 0), unit))) < hair);
    for (const double turn : {0.1, 0.5, 2.0, 2 * pi}) {
      CAPTURE(turn);
      const FittedPrimitive cylinder =
          measured(placed(patch(on_cylinder, 0, turn, 0, 3), unit), tolerance);
      CHECK(cylinder.kind == Kind::Cylinder);
      CHECK(cylinder.radius == Approx(2 * unit).epsilon(1e-6));
      CHECK(cylinder.deviation < hair);
      CHECK(cylinder.distance(placed(Vec3(3, 0, 7), unit)) == Approx(unit).epsilon(1e-5));
    }
    for (const double turn : {0.1, 1.0, pi / 2}) {
      CAPTURE(turn);
      const FittedPrimitive sphere =
          measured(placed(patch(on_sphere, 0, turn, 0, turn - 1e-3), unit), tolerance);
      CHECK(sphere.kind == Kind::Sphere);
      CHECK(sphere.radius == Approx(2 * unit).epsilon(1e-6));
      CHECK((sphere.origin - placed(Vec3::Zero(), unit)).norm() < 1e-5 * unit);
    }
    for (const double turn : {0.5, 2.0, 2 * pi}) {
      CAPTURE(turn);
      const FittedPrimitive cone = measured(placed(patch(on_cone, 0, turn, 0, 2), unit), tolerance);
      CHECK(cone.kind == Kind::Cone);
      CHECK(cone.half_angle == Approx(0.3).epsilon(1e-6));
      CHECK(cone.radius == Approx(unit * (1 + 2 * std::tan(0.3))).epsilon(1e-6));
      CHECK((cone.origin - placed(Vec3(0, 0, -1 / std::tan(0.3)), unit)).norm() < 1e-5 * unit);
    }
    for (const double turn : {0.6, 2.0, 2 * pi})
      for (const double around : {0.0, 1.5, 3.0}) {
        CAPTURE(turn, around);
        const FittedPrimitive torus =
            measured(placed(patch(on_torus, 0, turn, around, around + 1), unit), tolerance);
        CHECK(torus.kind == Kind::Torus);
        CHECK(torus.radius == Approx(unit).epsilon(1e-5));
        CHECK(torus.major_radius == Approx(3 * unit).epsilon(1e-5));
        CHECK(torus.deviation < 1e-6 * unit);
      }
  }
}

TEST_CASE("surfaces that are no primitive are none", "[skinning][surfaces]") {
  const auto kind = [](const std::function<Vec3(double, double)>& x, double s0, double s1,
                       double t0, double t1) {
    const Patch made = patch(x, s0, s1, t0, t1);
    const double size = (made.x.colwise().maxCoeff() - made.x.colwise().minCoeff()).norm();
    return measured(made, 1e-4 * size).kind;
  };
  const auto ellipsoid = [](double s, double t) {
    return Vec3(3 * std::cos(s) * std::cos(t), 2 * std::sin(s) * std::cos(t), 1.5 * std::sin(t));
  };
  CHECK(kind(ellipsoid, 0, pi / 2, 0, 1.4) == Kind::Free);
  CHECK(kind(ellipsoid, 0.5, 0.9, 0.3, 0.7) == Kind::Free);
  CHECK(kind([](double s, double t) { return Vec3(s, t, s * t); }, -1, 1, -1, 1) == Kind::Free);
  CHECK(kind([](double s, double t) { return Vec3(s, t, 0.3 * (s * s - t * t)); }, -1, 1, -1, 1) ==
        Kind::Free);
  // Cylinders over an ellipse and over a wave.
  CHECK(kind([](double s, double t) { return Vec3(2 * std::cos(s), std::sin(s), t); }, 0, 3, 0,
             2) == Kind::Free);
  CHECK(kind([](double s, double t) { return Vec3(s, t, 0.1 * std::sin(3 * s)); }, 0, 3, 0, 2) ==
        Kind::Free);
  // A crowned panel: a sag of a hundredth means curvature in all directions, and no significant
  // radius.
  CHECK(kind([](double s, double t) { return Vec3(s, t, 0.02 * (1 - s * s) * (1 - t * t)); }, -1, 1,
             -1, 1) == Kind::Free);
}

TEST_CASE("a patch that hardly turns is a plane or nothing", "[skinning][surfaces]") {
  const auto sheet = [](double turn) {
    const double r = 1 / turn;
    return patch(
        [r](double s, double t) { return Vec3(r * std::sin(s / r), t, r * std::cos(s / r)); }, 0, 1,
        0, 1);
  };
  CHECK(measured(sheet(1e-4), 1e-4).kind == Kind::Plane);
  CHECK(measured(sheet(0.03), 1e-4).kind == Kind::Free);
  CHECK(measured(sheet(0.1), 1e-4).kind == Kind::Cylinder);
  // With noise of half the tolerance, its radius is known only to a tenth.
  Patch noisy = sheet(0.06);
  for (long i = 0; i < noisy.x.rows(); ++i)
    noisy.x(i, 2) += 1e-3 * std::sin(7.0 * static_cast<double>(i * i));
  CHECK(measured(noisy, 2e-3).kind == Kind::Free);
}

TEST_CASE("a narrow band of a cone is no sphere, though one is within the tolerance",
          "[skinning][surfaces]") {
  const auto band = [](double s, double t) {
    const double r = 38 - 0.3 * t;
    return Vec3(r * std::cos(s), r * std::sin(s), t);
  };
  const Patch narrow = patch(band, 0, pi, 0, 2);
  const FittedPrimitive shape = measured(narrow, 0.03);
  CHECK(shape.kind == Kind::Cone);
  CHECK(shape.half_angle == Approx(std::atan(0.3)).epsilon(1e-4));
}

TEST_CASE("shapes that deviate from a primitive by more than the tolerance are none",
          "[skinning][surfaces]") {
  Patch dented = patch(on_cylinder, 0, 2, 0, 3);
  dented.x.row(300) += 0.01 * dented.n.row(300);
  CHECK(measured(dented, 0.02).kind == Kind::Cylinder);
  CHECK(measured(dented, 0.02).deviation == Approx(0.01).epsilon(0.05));
  CHECK(measured(dented, 0.005).kind == Kind::Free);
}
