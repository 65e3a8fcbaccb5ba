// SPDX-License-Identifier: MPL-2.0
// A curve under named loads.
#include <cmath>

#include "batten/sculpting/curves/deformable_curve.h"

#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// A wavy arch between (0,0,0) and (10,0,0).
HermiteCurve arch(double scale = 1, const Vec3& origin = Vec3::Zero()) {
  std::vector<double> u;
  Points x(11, 3), d(11, 3);
  for (int i = 0; i <= 10; ++i) {
    const double t = i;
    u.push_back(scale * t);
    x.row(i) =
        (scale * Vec3(t, 0.1 * std::sin(2 * t), 2 * std::sin(t * M_PI / 10)) + origin).transpose();
    d.row(i) << 1, 0.2 * std::cos(2 * t), 0.2 * M_PI * std::cos(t * M_PI / 10);
  }
  return {u, x, d};
}

ConstraintSet ends(const HermiteCurve& curve, bool clamped = true) {
  ConstraintSet set(curve.mesh().dof_count());
  CurveConstraints rows(curve.mesh(), set);
  for (const double u : {curve.start(), curve.end()}) {
    rows.point("end", u, curve.evaluate(u));
    if (clamped) rows.derivative("slope", u, curve.evaluate(u, 1));
  }
  return set;
}

std::vector<CurveLoad> loads(double scale = 1, const Vec3& origin = Vec3::Zero()) {
  return {{"wind", 0, CurveLoad::Uniform{Vec3::UnitY()}},
          {"push", 0, CurveLoad::Force{scale * Vec3(3, 0, 0) + origin, Vec3::UnitZ()}},
          {"spring", 0,
           CurveLoad::Spring{scale * Vec3(5, 0, 2) + origin, scale * Vec3(5, 0, 4) + origin}}};
}

double difference(const HermiteCurve& a, const HermiteCurve& b) {
  return (a.dofs() - b.dofs()).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("without loads a curve keeps its shape, or bends straight when it has none",
          "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  DeformableCurve kept(shape, ends(shape), {}, loads());
  CHECK(difference(kept.solve(), shape) < 1e-12);
  CurveMaterial plain;
  plain.starts_unstressed = false;
  DeformableCurve straight(shape, ends(shape, false), plain, loads());
  const HermiteCurve line = straight.solve();
  for (int k = 0; k <= 20; ++k)
    CHECK((line.evaluate(k / 2.0) - shape.evaluate(0) -
           k / 20.0 * (shape.evaluate(10) - shape.evaluate(0)))
              .norm() < 1e-12);
}

TEST_CASE("loads act linearly, and a beam under them sags as in theory", "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  curve.set("wind", 1);
  const Points one = curve.solve().dofs() - shape.dofs();
  curve.set("wind", -2.5);
  CHECK((Points(curve.solve().dofs() - shape.dofs()) + 2.5 * one).norm() < 1e-11);
  // Relative: f̂ L⁴/(384 β̂) of the curve of length 1, whose length is 10 here.
  CHECK(one(10, 1) == Approx(10.0 / 384).epsilon(1e-9));
  curve.set("wind", 0);
  curve.set("push", 1);
  const Points push = curve.solve().dofs() - shape.dofs();
  CHECK(push.col(0).norm() + push.col(1).norm() < 1e-10);
  CHECK(push(6, 2) > 0);
}

TEST_CASE("a spring pulls its point towards its end, to it when it is stiff",
          "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  const double u = shape.closest_point({5, 0, 2}).u;
  double before = (shape.evaluate(u) - Vec3(5, 0, 4)).norm();
  for (const double stiffness : {10.0, 1e3, 1e5, 1e9}) {
    curve.set("spring", stiffness);
    const double distance = (curve.solve().evaluate(u) - Vec3(5, 0, 4)).norm();
    CHECK(distance < before);
    before = distance;
  }
  CHECK(before < 1e-5);
  curve.set_spring_target("spring", {5, 1, 1});
  CHECK((curve.solve().evaluate(u) - Vec3(5, 1, 1)).norm() < 1e-5);
  CHECK(curve.constraints().max_residual(curve.solve().dofs()) < 1e-12);
}

TEST_CASE("relative numbers make the same shape in mm and in m, near and far",
          "[sculpting][curves]") {
  const auto loaded = [](double scale, const Vec3& origin) {
    const HermiteCurve shape = arch(scale, origin);
    DeformableCurve curve(shape, ends(shape), {}, loads(scale, origin));
    curve.set("wind", 20);
    curve.set("push", 30);
    curve.set("spring", 100);
    return curve.solve();
  };
  const HermiteCurve metres = loaded(1, Vec3::Zero()), millimetres = loaded(1000, Vec3::Zero()),
                     far = loaded(1, {1e5, -1e5, 0});
  for (int k = 0; k <= 10; ++k) {
    CHECK((1000 * metres.evaluate(k) - millimetres.evaluate(1000 * k)).norm() < 1e-7);
    CHECK((metres.evaluate(k) + Vec3(1e5, -1e5, 0) - far.evaluate(k)).norm() < 1e-8);
  }
}

TEST_CASE("motion converges to the static solution, its energy never growing",
          "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  CurveMaterial material;
  material.damping = 20;
  DeformableCurve curve(shape, ends(shape), material, loads());
  curve.set("wind", 30);
  curve.set("spring", 50);
  const HermiteCurve still = curve.solve();
  curve.set("wind", 0);
  curve.solve();
  curve.start_motion(0.02);
  curve.set("wind", 30);
  double before = curve.energy();
  HermiteCurve moving;
  for (int i = 0; i < 2000; ++i) {
    moving = curve.step();
    const double now = curve.energy();
    CHECK(now <= before + 1e-9 * std::abs(before));
    before = now;
    if (i == 0) CHECK(difference(moving, still) > 1e-4);
  }
  CHECK(difference(moving, still) < 1e-8);
  // A stiffness may change during the motion.
  curve.set("spring", 500);
  for (int i = 0; i < 2000; ++i) moving = curve.step();
  CHECK(difference(moving, curve.solve()) < 1e-8);
}

// A straight bar of length 1 between two points.
HermiteCurve bar(int segments = 12) {
  std::vector<double> u;
  Points x(segments + 1, 3), d(segments + 1, 3);
  for (int i = 0; i <= segments; ++i) {
    u.push_back(static_cast<double>(i) / segments);
    x.row(i) << u.back(), 0, 0;
    d.row(i) << 1, 0, 0;
  }
  return {u, x, d};
}

// The bar bent by a uniform load that is then removed.
struct ReleasedBar {
  HermiteCurve rest = bar();
  ConstraintSet held = ends(rest, false);
  CurveMaterial material;
  Modes modes;
  DeformableCurve curve;
  MatX start;
  ReleasedBar(double density, double damping)
      : material{.density = density, .damping = damping},
        modes(held, CurveAssembler(rest.mesh()).stiffness({0}, {1}),
              CurveAssembler(rest.mesh()).mass()),
        curve(rest, held, material, {{"wind", 1, CurveLoad::Uniform{{0.2, -0.5, 1}}}}) {
    start = of(curve.solve());
    curve.set("wind", 0);
  }
  MatX of(const HermiteCurve& shape) const { return modes.of(shape.dofs() - rest.dofs()); }
};

TEST_CASE("every mode of a bar follows the formula of the time integration scheme",
          "[sculpting][curves]") {
  for (const double theta : {0.5, 0.8, 1.0}) {
    ReleasedBar bar(2, 3);
    const double dt = 0.01;
    bar.curve.start_motion(dt, theta);
    std::vector<ModeSteps> reference_curve;
    for (long k = 0; k < bar.start.rows(); ++k)
      for (int c = 0; c < 3; ++c)
        reference_curve.push_back({2, 3, bar.modes.lambda[k], dt, theta, bar.start(k, c)});
    double worst = 0;
    for (int n = 0; n < 100; ++n) {
      const MatX now = bar.of(bar.curve.step());
      for (long k = 0; k < bar.start.rows(); ++k)
        for (int c = 0; c < 3; ++c) {
          ModeSteps& mode = reference_curve[static_cast<size_t>(3 * k + c)];
          mode.step();
          worst = std::max(worst, std::abs(now(k, c) - mode.x));
        }
    }
    CHECK(worst < 1e-10 * bar.start.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a bar's frequency and damping, first and second order in dt", "[sculpting][curves]") {
  const double damping = 2, lambda = std::pow(pi, 4), period = 2 * pi / std::sqrt(lambda);
  for (const double theta : {1.0, 0.5}) {
    std::vector<double> error;
    for (const int steps : {200, 400, 800}) {
      ReleasedBar bar(1, damping);
      // Ends fixed in position: λ = π⁴.
      CHECK(bar.modes.lambda[0] == Approx(lambda).epsilon(1e-5));
      bar.curve.start_motion(2 * period / steps, theta);
      HermiteCurve shape;
      for (int n = 0; n < steps; ++n) shape = bar.curve.step();
      const double exact =
          ModeSteps::exact(1, damping, bar.modes.lambda[0], bar.start(0, 2), 2 * period);
      error.push_back(std::abs(bar.of(shape)(0, 2) - exact) / std::abs(bar.start(0, 2)));
    }
    INFO("theta " << theta << " errors " << error[0] << " " << error[1] << " " << error[2]);
    CHECK(std::log2(error[1] / error[2]) == Approx(theta == 1 ? 1 : 2).margin(0.1));
    CHECK(error[2] < (theta == 1 ? 0.1 : 1e-3));
  }
}

TEST_CASE("a bar's energy never grows, in steps of a thousand periods neither",
          "[sculpting][curves]") {
  const double period = 2 / pi;
  for (const double theta : {0.5, 1.0})
    for (const double dt : {0.01 * period, period, 1000 * period}) {
      ReleasedBar bar(1, 0.5);
      bar.curve.set("wind", -2);
      bar.curve.start_motion(dt, theta);
      double before = bar.curve.energy();
      const double scale = std::abs(before);
      double grown = -1e300, farthest = 0;
      for (int n = 0; n < 300; ++n) {
        const HermiteCurve shape = bar.curve.step();
        const double now = bar.curve.energy();
        grown = std::max(grown, now - before);
        before = now;
        farthest = std::max(farthest, difference(shape, bar.rest));
      }
      INFO("theta " << theta << " dt " << dt << " grew by " << grown / scale);
      CHECK(grown < 1e-10 * scale);
      CHECK(farthest < 1);
    }
}

TEST_CASE("a stiffness that changes in motion changes neither position nor speed",
          "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  curve.start_motion(0.01);
  curve.set("wind", 30);
  for (int i = 0; i < 20; ++i) curve.step();
  const HermiteCurve before = curve.step();
  curve.solve();  // solving for the static shape is not a step
  curve.set("spring", 1e-9);
  const HermiteCurve after = curve.step();
  DeformableCurve reference_curve(shape, ends(shape), {}, loads());
  reference_curve.start_motion(0.01);
  reference_curve.set("wind", 30);
  for (int i = 0; i < 21; ++i) reference_curve.step();
  CHECK(difference(after, reference_curve.step()) < 1e-9);
  CHECK(difference(after, before) > 1e-6);
  curve.set("spring", 50);
  const double energy = curve.energy();
  curve.step();
  CHECK(curve.energy() <= energy + 1e-9 * std::abs(energy));
}

TEST_CASE("curve loads that make no sense are refused by name", "[sculpting][curves]") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  CHECK_THAT(error_message([&] { curve.set("sprin", 1); }), Contains("did you mean 'spring'"));
  CHECK_THAT(error_message([&] { curve.set("spring", -1); }),
             Contains("'spring'") && Contains("0 or more"));
  CHECK_THAT(error_message([&] { curve.set("wind", NAN); }),
             Contains("'wind'") && Contains("finite"));
  CHECK_THAT(error_message([&] {
               curve.set_spring_target("wind", {0, 0, 0});
             }),
             Contains("is not a spring"));
  CHECK_THAT(error_message([&] { curve.step(); }), Contains("motion"));
  auto twice = loads();
  twice.push_back(twice[0]);
  CHECK_THAT(error_message([&] { DeformableCurve(shape, ends(shape), {}, twice); }),
             Contains("two loads") && Contains("'wind'"));
  CHECK_THROWS_AS(DeformableCurve(shape, ConstraintSet(3), {}, {}), InputError);
  DeformableCurve loose(shape, ConstraintSet(shape.mesh().dof_count()), {}, loads());
  CHECK_THROWS_AS(loose.solve(), NoSolutionError);
}
