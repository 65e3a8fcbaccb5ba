// A curve under loads with names.
#include <cmath>

#include "batten/sculpting/deformable_curve.h"

#include "batten/constraints/shape/curve_constraints.h"
#include "batten/core/errors.h"
#include "batten/tests/catch.h"
#include "batten/tests/refusal.h"
#include "batten/tests/sampling.h"

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

TEST_CASE("without loads a curve keeps its shape, or bends straight when it has none") {
  const HermiteCurve shape = arch();
  DeformableCurve kept(shape, ends(shape), {}, loads());
  CHECK(difference(kept.solve(), shape) < 1e-12);
  CurveMaterial plain;
  plain.keeps_shape = false;
  DeformableCurve straight(shape, ends(shape, false), plain, loads());
  const HermiteCurve line = straight.solve();
  for (int k = 0; k <= 20; ++k)
    CHECK((line.evaluate(k / 2.0) - shape.evaluate(0) -
           k / 20.0 * (shape.evaluate(10) - shape.evaluate(0)))
              .norm() < 1e-12);
}

TEST_CASE("loads act linearly, and a beam under them sags as the book says") {
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

TEST_CASE("a spring pulls its point towards its end, to it when it is stiff") {
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
  curve.pull_to("spring", {5, 1, 1});
  CHECK((curve.solve().evaluate(u) - Vec3(5, 1, 1)).norm() < 1e-5);
  CHECK(curve.constraints().max_residual(curve.solve().dofs()) < 1e-12);
}

TEST_CASE("relative numbers make the same shape in mm and in m, near and far") {
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

TEST_CASE("motion settles where the static solution is, its energy never growing") {
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
  // A stiffness may change on the way.
  curve.set("spring", 500);
  for (int i = 0; i < 2000; ++i) moving = curve.step();
  CHECK(difference(moving, curve.solve()) < 1e-8);
}

TEST_CASE("a stiffness that changes in motion changes neither place nor speed") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  curve.start_motion(0.01);
  curve.set("wind", 30);
  for (int i = 0; i < 20; ++i) curve.step();
  const HermiteCurve before = curve.step();
  curve.solve();  // a look at the static shape is no step
  curve.set("spring", 1e-9);
  const HermiteCurve after = curve.step();
  DeformableCurve twin(shape, ends(shape), {}, loads());
  twin.start_motion(0.01);
  twin.set("wind", 30);
  for (int i = 0; i < 21; ++i) twin.step();
  CHECK(difference(after, twin.step()) < 1e-9);
  CHECK(difference(after, before) > 1e-6);
  curve.set("spring", 50);
  const double energy = curve.energy();
  curve.step();
  CHECK(curve.energy() <= energy + 1e-9 * std::abs(energy));
}

TEST_CASE("curve loads that make no sense are refused by name") {
  const HermiteCurve shape = arch();
  DeformableCurve curve(shape, ends(shape), {}, loads());
  CHECK_THAT(refusal([&] { curve.set("sprin", 1); }), Contains("did you mean 'spring'"));
  CHECK_THAT(refusal([&] { curve.set("spring", -1); }),
             Contains("'spring'") && Contains("0 or more"));
  CHECK_THAT(refusal([&] { curve.set("wind", NAN); }), Contains("'wind'") && Contains("finite"));
  CHECK_THAT(refusal([&] { curve.pull_to("wind", {0, 0, 0}); }), Contains("no spring"));
  CHECK_THAT(refusal([&] { curve.step(); }), Contains("motion"));
  auto twice = loads();
  twice.push_back(twice[0]);
  CHECK_THAT(refusal([&] { DeformableCurve(shape, ends(shape), {}, twice); }),
             Contains("two loads") && Contains("'wind'"));
  CHECK_THROWS_AS(DeformableCurve(shape, ConstraintSet(3), {}, {}), InputError);
  DeformableCurve loose(shape, ConstraintSet(shape.mesh().dof_count()), {}, loads());
  CHECK_THROWS_AS(loose.solve(), NoSolutionError);
}
