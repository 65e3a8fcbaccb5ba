// SPDX-License-Identifier: MPL-2.0
// Geometric constraints of curves, and motion under them.
#include <cmath>

#include "batten/constraints/constrained_solver.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/errors.h"
#include "batten/fem/curve_assembler.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/kkt_solver.h"
#include "batten/tests/support/sampling.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// Unit springs from every dof to random targets: any constraint set then has a solution.
struct Soft {
  CurveMesh mesh;
  SparseMatrix K;
  Points F;
  explicit Soft(CurveMesh m) : mesh(std::move(m)) {
    const CurveAssembler assembler(mesh);
    K = assembler.stiffness({0.1}, {0.01}) + assembler.mass();
    Random random(5);
    F.resize(mesh.dof_count(), 3);
    for (long d = 0; d < F.rows(); ++d) F.row(d) = random.point();
  }
};

HermiteCurve solved(const Soft& soft, const ConstraintSet& set) {
  const Points x = solve_constrained(set, soft.K, soft.F),
               expected = solve_kkt(set, soft.K, soft.F);
  CHECK((x - expected).norm() < 1e-10 * (1 + expected.norm()));
  return {soft.mesh, x};
}

}  // namespace

TEST_CASE("each constraint of a curve holds exactly, and reduction equals the saddle point system",
          "[constraints][curves]") {
  for (const CurveMesh& mesh : {CurveMesh({0, 1, 1.7, 3}), CurveMesh({0, 1, 1.5, 2, 3}, true),
                                CurveMesh({0, 1, 1.7, 3}, false, {2})}) {
    const Soft soft(mesh);
    const Vec3 p(1, -2, 0.5), n = Vec3(1, 2, 3).normalized();
    {
      ConstraintSet set(mesh.dof_count());
      CurveConstraints rows(mesh, set);
      rows.point("p", 1.3, p);
      rows.derivative("d", 0.4, p);
      rows.zero_curvature("k", 0);
      rows.direction("t", 2.5, n);
      const HermiteCurve curve = solved(soft, set);
      CHECK((curve.evaluate(1.3) - p).norm() < 1e-13);
      CHECK((curve.evaluate(0.4, 1) - p).norm() < 1e-13);
      CHECK(curve.evaluate(0.0, 2).norm() < 1e-12);
      CHECK(curve.evaluate(2.5, 1).cross(n).norm() < 1e-13);
      CHECK(curve.evaluate(2.5, 1).norm() > 1e-3);
    }
    {
      ConstraintSet set(mesh.dof_count());
      CurveConstraints(mesh, set).in_plane("plane", p, 7 * n);
      const HermiteCurve curve = solved(soft, set);
      for (int k = 0; k <= 40; ++k)
        CHECK(std::abs(n.dot(curve.evaluate(3 * k / 40.0) - p)) < 1e-13);
    }
  }
}

TEST_CASE("a symmetric curve is its own mirror image, open, closed, with corners",
          "[constraints][curves]") {
  for (const CurveMesh& mesh :
       {CurveMesh({0, 1, 1.5, 2, 3}), CurveMesh({0, 1, 2, 3}), CurveMesh({0, 1, 1.5, 2, 3}, true),
        CurveMesh({0, 1, 1.5, 2, 3}, false, {1, 3}), CurveMesh({0, 1, 1.5, 2, 3}, false, {2}),
        CurveMesh({0, 1, 1.5, 2, 3}, true, {0, 1, 3})}) {
    const Soft soft(mesh);
    const Vec3 p(1, -2, 0.5), n = Vec3(1, 2, 3).normalized();
    ConstraintSet set(mesh.dof_count());
    CurveConstraints(mesh, set).symmetric("mirror", p, n);
    const HermiteCurve curve = solved(soft, set);
    for (int k = 0; k <= 60; ++k) {
      const Vec3 a = curve.evaluate(3 * k / 60.0), b = curve.evaluate(3 - 3 * k / 60.0);
      CHECK((a - 2 * n.dot(a - p) * n - b).norm() < 1e-12);
    }
  }
  const CurveMesh uneven({0, 1, 3});
  ConstraintSet set(uneven.dof_count());
  CHECK_THAT(error_message([&] {
               CurveConstraints(uneven, set).symmetric("mirror", {0, 0, 0}, {1, 0, 0});
             }),
             Contains("'mirror'") && Contains("no mirror image"));
  CHECK_THAT(error_message([&] { CurveConstraints(uneven, set).direction("t", 0, Vec3::Zero()); }),
             Contains("'t'") && Contains("length 0"));
  ConstraintSet other(3);
  CHECK_THAT(error_message([&] { CurveConstraints(uneven, other); }), Contains("3 dofs"));
}

TEST_CASE("motion: one long implicit Euler step is the static solution", "[constraints][curves]") {
  const Soft soft(CurveMesh({0, 1, 1.5, 2, 3}));
  for (const bool coupled : {false, true}) {
    ConstraintSet set(soft.mesh.dof_count());
    CurveConstraints rows(soft.mesh, set);
    rows.point("start", 0, {1, 2, 3});
    if (coupled) rows.in_plane("plane", {1, 2, 3}, {0, 1, 1});
    const SparseMatrix M = CurveAssembler(soft.mesh).mass();
    ThetaIntegrator steps(set, soft.K, M, {1, 1, 1e9, 1});
    const Points wanted = solve_constrained(set, soft.K, soft.F);
    CHECK((steps.step(soft.F) - wanted).norm() < 1e-7);
    CHECK(set.max_residual(steps.positions()) < 1e-12);
    // Small steps converge to it, too, and never gain energy.
    ThetaIntegrator slow(set, soft.K, M, {1, 0.5, 0.05, 1});
    double before = slow.kinetic() + slow.potential(soft.F);
    for (int i = 0; i < 4000; ++i) {
      slow.step(soft.F);
      const double now = slow.kinetic() + slow.potential(soft.F);
      CHECK(now <= before + 1e-12 * std::abs(before));
      before = now;
    }
    CHECK((slow.positions() - wanted).norm() < 1e-6);
    CHECK(set.max_residual(slow.positions()) < 1e-11);
  }
}

TEST_CASE(
    "motion: the trapezoidal rule keeps energy, loses what damping takes, and is of second order",
    "[constraints][curves]") {
  const Soft soft(CurveMesh({0, 1, 1.5, 2, 3}));
  ConstraintSet set(soft.mesh.dof_count());
  CurveConstraints(soft.mesh, set).point("start", 0, {1, 2, 3});
  const SparseMatrix M = CurveAssembler(soft.mesh).mass();
  const auto mass_product = [&](const Points& v) {
    return v.cwiseProduct(Points(M.selfadjointView<Eigen::Lower>() * v)).sum();
  };
  for (const double damping : {0.0, 0.7}) {
    ThetaIntegrator steps(set, soft.K, M, {2, damping, 0.1, 0.5});
    double energy = steps.kinetic() + steps.potential(soft.F), lost = 0;
    for (int i = 0; i < 200; ++i) {
      const Points v0 = steps.velocities();
      steps.step(soft.F);
      lost += damping * 0.1 * mass_product(0.5 * (v0 + steps.velocities()));
    }
    CHECK(energy - lost == Approx(steps.kinetic() + steps.potential(soft.F)).epsilon(1e-10));
  }
  const auto at_two = [&](int n, double theta) {
    ThetaIntegrator steps(set, soft.K, M, {1, 0.3, 2.0 / n, theta});
    for (int i = 0; i < n; ++i) steps.step(soft.F);
    return steps.positions();
  };
  const Points exact = at_two(12800, 0.5);
  for (const auto& [theta, order] : {std::pair(0.5, 2.0), {1.0, 1.0}}) {
    const double coarse = (at_two(theta < 1 ? 200 : 3200, theta) - exact).norm(),
                 fine = (at_two(theta < 1 ? 400 : 6400, theta) - exact).norm();
    CHECK(std::log2(coarse / fine) == Approx(order).margin(0.1));
  }
}

TEST_CASE("motion that makes no sense is refused", "[constraints][curves]") {
  const Soft soft(CurveMesh({0, 1}));
  ConstraintSet set(soft.mesh.dof_count());
  const SparseMatrix M = CurveAssembler(soft.mesh).mass();
  const auto with = [&](ThetaIntegrator::Options o) {
    return error_message([&] { ThetaIntegrator(set, soft.K, M, o); });
  };
  CHECK_THAT(with({1, 1, 0, 1}), Contains("time step"));
  CHECK_THAT(with({-1, 1, 1, 1}), Contains("density"));
  CHECK_THAT(with({0, 0, 1, 1}), Contains("not both 0"));
  CHECK_THAT(with({1, 1, 1, 0.2}), Contains("theta"));
  const ConstraintSet small(3);
  CHECK_THAT(error_message([&] {
               ThetaIntegrator(small, soft.K, M, {1, 1, 1, 1});
             }),
             Contains("4 × 4"));
  ThetaIntegrator steps(set, soft.K, M, {1, 1, 1, 1});
  CHECK_THAT(error_message([&] { steps.start(Points::Zero(2, 3), Points::Zero(4, 3)); }),
             Contains("2 positions"));
}
