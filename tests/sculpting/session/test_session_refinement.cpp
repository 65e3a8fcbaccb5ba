// SPDX-License-Identifier: MPL-2.0
// Refinement during a session.
#include "batten/core/errors.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;

namespace {

SculptingSession sculpted(double edge) {
  SculptingSession session(patch_layout(edge), with_material(0.1, 1));
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {Area::Painted{{{{0.4, 0.6, 0.3}, 0.5, 1}}}}}},
              {slider("f", 20)});
  session.add(Load{"p", Load::Pressure{}}, {slider("p", 3)});
  session.add(Load{"finger", Load::Point{{1.2, 0.5, 0.2}, {0, 0, 1}}}, {slider("finger", 1)});
  session.solve_to_equilibrium();
  session.add(Constraint{"pin", Constraint::Point{{1.2, 0.8, 0.2}, {1.2, 0.8, 0.3}}});
  session.add(Constraint{"plane", Constraint::LineNormal{"rib", {}}});
  return session;
}

double energy_of(const SculptingSession& session) {
  const SurfaceEnergy e = session.energy();
  return e.bending + e.stretching;
}

}  // namespace

TEST_CASE("a refinement keeps the surface on every old edge, and reports the change inside",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.4), {});
  session.add(Load{"f", Load::Uniform{{0, 0, 1}, {}}}, {slider("f", 10)});
  session.solve_to_equilibrium();
  const Surface before = shape_of(session);
  const double energy = energy_of(session);
  const RefinementReport report = session.refine({Refinement::JumpIndicator{0.5}});
  CHECK(report.triangles_before == before.mesh().triangle_count());
  CHECK(report.triangles == session.layout().mesh()->triangle_count());
  CHECK(report.triangles > report.triangles_before);
  CHECK(report.energy_before == Approx(energy));
  CHECK(report.energy_at_equilibrium == Approx(energy_of(session)));
  CHECK(report.energy_transferred >= report.energy_at_equilibrium * (1 - 1e-3) - 1e-12);
  CHECK(report.max_displacement >= 0);
  CHECK(report.max_displacement < 0.01);
  CHECK(session.residual() < 1e-11);
  // Curves are interpolated on the refined triangles.
  const Surface after = shape_of(session);
  for (const char* name : {"bottom", "rib", "left"}) {
    const HermiteCurve line = session.line(name);
    for (int k = 0; k <= 20; ++k)
      CHECK(after.closest_point(line.evaluate(line.start() + (line.end() - line.start()) * k / 20))
                .distance < 1e-9);
  }
}

TEST_CASE("loads and constraints go along: refined everywhere it is the session on a finer mesh",
          "[sculpting][session]") {
  SculptingSession session = sculpted(0.4);
  const auto names = session.names();
  const auto values = session.parameters().values();
  const double coarse = energy_of(session);
  for (int round = 0; round < 2; ++round)
    session.refine({Refinement::Brush{{{{0.8, 0.6, 0.2}, 5, 1}}}});
  CHECK(session.names() == names);
  CHECK(session.parameters().values() == values);
  CHECK(session.residual() < 1e-11);
  SculptingSession fresh = sculpted(0.2);
  SculptingSession finest = sculpted(0.1);
  const double is = energy_of(session), should = energy_of(finest);
  INFO(coarse << " refined " << is << " fresh " << energy_of(fresh) << " finest " << should);
  CHECK(is == Approx(should).epsilon(0.02));
  const Surface a = shape_of(session), b = shape_of(finest);
  double worst = 0;
  for (const Vec2& p : {Vec2(0.3, 0.3), Vec2(0.5, 0.9), Vec2(1.2, 0.3), Vec2(1.3, 0.9)}) {
    const auto foot_point = b.closest_point({p.x(), p.y(), 0.3});
    worst = std::max(worst, a.closest_point(b.position(foot_point.where)).distance);
  }
  CHECK(worst < 5e-3);
  // Sliders still work.
  session.set("f", 0);
  session.set("p", 0);
  session.set("finger", 0);
  CHECK(session.solve_to_equilibrium().converged);
}

TEST_CASE("the brush refines under its strokes only, down to the smallest edge",
          "[sculpting][session]") {
  SculptingSession session(square_layout(0.25, 2), {});
  const auto small_triangles = [&](const Vec3& at, double radius) {
    const Surface shape = shape_of(session);
    double smallest_in = 1e9, smallest_out = 1e9;
    for (int t = 0; t < shape.mesh().triangle_count(); ++t) {
      const double area = shape.mesh().shape(t).area;
      double& smallest = (shape.position({t, Vec3::Constant(1.0 / 3)}) - at).norm() < radius
                             ? smallest_in
                             : smallest_out;
      smallest = std::min(smallest, area);
    }
    return std::pair(smallest_in, smallest_out);
  };
  const Vec3 at(0.5, 0.5, 0);
  const auto [in, out] = small_triangles(at, 1);
  Refinement refinement{Refinement::Brush{{{at, 0.2, 1}}}, 0.02};
  int rounds = 0, triangles = 0;
  for (; rounds < 20; ++rounds) {
    const RefinementReport report = session.refine(refinement);
    if (report.triangles == report.triangles_before) break;
    triangles = report.triangles;
  }
  CHECK(rounds < 20);
  CHECK(triangles < 3000);
  const auto [in2, out2] = small_triangles(at, 1);
  CHECK(in2 < in / 16);
  CHECK(out2 >= out / 4);
  // No edge is shorter than the limit.
  const ParametricMesh& mesh = *session.layout().mesh();
  for (int e = 0; e < mesh.edge_count(); ++e)
    CHECK(mesh.edge_length(e) * session.layout().size() > 0.99 * 0.02 / std::sqrt(2.0));
}

TEST_CASE("jumps of curvature find where a finger presses", "[sculpting][session]") {
  SculptingSession session(square_layout(0.25, 2), {});
  session.add(Load{"finger", Load::Point{{0.4, 0.4, 0}, {0, 0, 1}}}, {slider("finger", 1)});
  session.solve_to_equilibrium();
  double before = energy_of(session);
  for (int round = 0; round < 4; ++round) {
    session.refine({Refinement::JumpIndicator{0.2}});
    // More dofs under the same force: the displacement and E, the work of the force, increase.
    CHECK(energy_of(session) > before);
    before = energy_of(session);
  }
  const ParametricMesh& mesh = *session.layout().mesh();
  const Surface shape = shape_of(session);
  double near = 1e9, far = 1e9;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const Vec3 p = shape.position({t, Vec3::Constant(1.0 / 3)});
    const double d = (p.head<2>() - Vec2(0.4, 0.4)).norm();
    if (d < 0.2) near = std::min(near, mesh.shape(t).area);
    if (d > 1.2 && p.head<2>().minCoeff() > 0.4 && p.head<2>().maxCoeff() < 1.6)
      far = std::min(far, mesh.shape(t).area);
  }
  CHECK(near < far / 3);
}

TEST_CASE("a motion goes on over a refinement", "[sculpting][session]") {
  SculptingSession session(square_layout(0.25), {});
  session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}}, {slider("push", 5)});
  session.solve_to_equilibrium();
  session.set("push", 0);
  session.start_motion({.dt = 0.005, .damping = 1});
  for (int n = 0; n < 10; ++n) session.step();
  const double energy = session.total_energy();
  session.refine({Refinement::Brush{{{{0.5, 0.5, 0}, 2, 1}}}});
  CHECK(session.total_energy() == Approx(energy).epsilon(0.05));
  double before = session.total_energy();
  for (int n = 0; n < 50; ++n) {
    session.step();
    CHECK(session.total_energy() <= before * (1 + 1e-9));
    before = session.total_energy();
  }
}

TEST_CASE("refinements that make no sense are refused", "[sculpting][session]") {
  SculptingSession session(square_layout(0.3), {});
  const Points before = session.dofs();
  CHECK_THROWS_AS(session.refine({Refinement::Brush{}}), InputError);
  CHECK_THROWS_AS(session.refine({Refinement::Brush{{{{0, 0, 0}, -1, 1}}}}), InputError);
  CHECK_THROWS_AS(session.refine({Refinement::JumpIndicator{0}}), InputError);
  CHECK_THROWS_AS(session.refine({Refinement::JumpIndicator{NAN}}), InputError);
  CHECK_THROWS_AS(session.refine({Refinement::JumpIndicator{}, -1}), InputError);
  CHECK_THROWS_AS(session.refine({Refinement::Brush{{{{0.5, 0.5, 0}, 5, 1}}}, 0, 10}), InputError);
  CHECK(same_bits(before, session.dofs()));
}
