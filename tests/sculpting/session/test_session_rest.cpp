// SPDX-License-Identifier: MPL-2.0
// Sessions with a rest shape: a fair one, or any other.
#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten;
using namespace batten_test;

namespace {

/// A quarter cylinder of radius 1 and length 2 from its four curves.
RegionLayout quarter_cylinder() {
  const auto arc = [](double y, bool back) {
    std::vector<Vec3> points;
    constexpr int n = 400;  // the spline has zero curvature at its ends
    for (int i = 0; i <= n; ++i) {
      const double a = pi / 2 * (back ? n - i : i) / n;
      points.emplace_back(std::cos(a), y, std::sin(a));
    }
    return curve_through_points("arc", points);
  };
  const auto straight = [](const Vec3& a, const Vec3& b) {
    return curve_through_points("side", {a, b});
  };
  return {"quarter",
          {{"low", arc(0, false)},
           {"top", straight({0, 0, 1}, {0, 2, 1})},
           {"high", arc(2, true)},
           {"side", straight({1, 2, 0}, {1, 0, 0})}},
          skin(0.35, 1e-4)};
}

/// Rest shapes of minimum variation, and the number of requests for them.
SessionOptions fair_options(int& calls) {
  SessionOptions options = with_material(0, 1);
  options.rest = [&calls](const RestShapeInput& task) {
    ++calls;
    MinimumVariationOptions fair;
    if (task.near.rows() > 0) fair.starts = {task.near};
    return fair_shape(task.layout, task.bent, task.rows, fair, task.progress).dofs;
  };
  return options;
}

double radius_error(const SculptingSession& session) {
  const Surface surface = shape_of(session);
  double worst = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    const Vec3 p = surface.position({t, Vec3::Constant(1.0 / 3)});
    worst = std::max(worst, std::abs(Vec2(p.x(), p.z()).norm() - 1));
  }
  return worst;
}

const Constraint held{"held", Constraint::Point{{0.7, 1, 0.7}, {0.7071, 1, 0.7071}}};

}  // namespace

TEST_CASE("an unloaded session stands in its rest shape, without energy and without motion",
          "[sculpting][session]") {
  int calls = 0;
  SculptingSession session(quarter_cylinder(), fair_options(calls));
  CHECK(calls == 1);
  CHECK(radius_error(session) < 5e-4);
  CHECK(radius_error(SculptingSession(quarter_cylinder(), with_material(0, 1))) > 0.02);
  CHECK(session.energy().bending < 1e-12);
  CHECK(std::abs(session.total_energy()) < 1e-9);
  CHECK(session.residual() < 1e-12);
  const Points still = session.dofs();
  session.start_motion({.dt = 0.1});
  for (int i = 0; i < 5; ++i) session.step();
  CHECK(difference(session.dofs(), still) < 1e-10);
}

TEST_CASE("linear loads bend a rest shape by as much as they bend any", "[sculpting][session]") {
  int calls = 0;
  SculptingSession fair(quarter_cylinder(), fair_options(calls)),
      bent(quarter_cylinder(), with_material(0, 1));
  const Points fair_before = fair.dofs(), bent_before = bent.dofs();
  for (SculptingSession* session : {&fair, &bent}) {
    session->add(Load{"push", Load::Uniform{{1, 0, 2}}}, {slider("push", 0.5)});
    session->solve_to_equilibrium();
  }
  const Points by = bent.dofs() - bent_before;
  CHECK(by.cwiseAbs().maxCoeff() > 1e-3);
  CHECK(difference(fair.dofs() - fair_before, by) < 1e-10);
  // A drag with superposition, a new material, and back.
  for (const double value : {0.1, 0.7, 0.5}) {
    fair.set("push", value);
    fair.solve_preview();
  }
  CHECK(difference(fair.dofs() - fair_before, by) < 1e-9);
  fair.set("beta", 2);
  fair.solve_to_equilibrium();
  CHECK(difference(fair.dofs() - fair_before, 0.5 * by) < 1e-9);
  fair.set("beta", 1);
  fair.solve_to_equilibrium();
  CHECK(difference(fair.dofs() - fair_before, by) < 1e-9);
  // Reactions balance the load: K acts only on the displacement from the rest shape.
  Vec3 sum = Vec3::Zero(), expected = Vec3::Zero();
  for (const Reaction& r : fair.reactions()) sum += r.force;
  for (const Reaction& r : bent.reactions()) expected += r.force;
  CHECK((sum - expected).norm() < 1e-8 * expected.norm());
  CHECK(calls == 1);
}

TEST_CASE("at rest the surface is fair again, wherever its rows have gone meanwhile",
          "[sculpting][session]") {
  int calls = 0;
  SculptingSession session(quarter_cylinder(), fair_options(calls));
  session.add(held);
  CHECK(calls == 1);
  const auto at = [&](double z) {
    session.set("held.z", z);
    session.solve_preview();
    CHECK(session.residual() < 1e-9);
    const int before = calls;
    session.solve_to_equilibrium();
    CHECK(calls == before + 1);
    session.solve_to_equilibrium();
    CHECK(calls == before + 1);
    CHECK(session.residual() < 1e-10);
    return session.dofs();
  };
  const Points there = at(0.75);
  at(0.68);
  CHECK(difference(at(0.75), there) < 1e-9);
  // Fairer than the linear result that it replaces: less curvature variation under the same
  // constraints.
  SculptingSession linear(quarter_cylinder(), fair_options(calls));
  linear.add(held);
  linear.set("held.z", 0.75);
  linear.solve_preview(20, 1e-12);
  CHECK(difference(linear.dofs(), there) > 1e-5);
  // Undo and redo restore the bits, including the rest shape: nothing is computed again.
  const Points now = session.dofs();
  const int before = calls;
  REQUIRE(session.undo());
  CHECK(difference(session.dofs(), now) > 1e-5);
  REQUIRE(session.redo());
  session.solve_to_equilibrium();
  CHECK(difference(session.dofs(), now) < 1e-12);
  CHECK(calls == before);
}

TEST_CASE("refinement and new curves keep the rest shape", "[sculpting][session]") {
  int calls = 0;
  SculptingSession session(quarter_cylinder(), fair_options(calls));
  const double before = radius_error(session);
  Refinement refinement;
  refinement.where = Refinement::Brush{{{{0.7, 1, 0.7}, 0.6}}};
  const RefinementReport report = session.refine(refinement);
  CHECK(report.triangles > report.triangles_before);
  CHECK(calls == 2);
  CHECK(radius_error(session) < 5e-4);
  CHECK(session.energy().bending < 1e-10);
  REQUIRE(session.undo());
  CHECK(radius_error(session) == before);
}

TEST_CASE(
    "a rest shape that cannot be made leaves the last good state, and none bends from nothing",
    "[sculpting][session]") {
  bool fails = false;
  SessionOptions options = with_material(0, 1);
  options.rest = [&](const RestShapeInput&) -> Points {
    if (fails) throw NoSolutionError("no such shape");
    return {};
  };
  SculptingSession session(quarter_cylinder(), options);
  const SculptingSession plain(quarter_cylinder(), with_material(0, 1));
  CHECK(difference(session.dofs(), plain.dofs()) < 1e-12);
  session.add(held);
  session.solve_to_equilibrium();
  const Points good = session.dofs();
  fails = true;
  session.set("held.z", 0.75);
  CHECK_THROWS_AS(session.solve_to_equilibrium(), NoSolutionError);
  CHECK(difference(session.dofs(), good) < 1e-12);
  CHECK(session.parameters().value("held.z") == 0.7071);
  options.rest = [](const RestShapeInput&) { return Points(Points::Zero(3, 3)); };
  CHECK_THROWS_AS(SculptingSession(quarter_cylinder(), options), InputError);
}
