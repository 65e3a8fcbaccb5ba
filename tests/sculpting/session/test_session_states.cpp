// SPDX-License-Identifier: MPL-2.0
// State that an update reuses from previous ones, and valid state after a failed one.
#include "batten/core/errors.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"

using namespace batten_test;

namespace {

Load springs(const std::string& name, double falloff) {
  Load::AttractorSprings kind;
  kind.at = {{0.5, 0.5, 0}};
  kind.target = Load::AttractorSprings::TargetPoints{{{0.5, 0.5, 0.5}}};
  kind.falloff = falloff;
  Load load;
  load.name = name;
  load.kind = kind;
  return load;
}

}  // namespace

TEST_CASE("responses to loads go when springs become stiffer", "[sculpting][session]") {
  SculptingSession session(square_layout(0.2), {});
  session.add(Load{"u", Load::Uniform{{0, 0, 1}}});
  session.add(springs("k", 0));
  for (const double u : {1.0, 2.0}) {
    session.set("u", u);
    session.solve_preview();
  }
  session.set("k", 100);
  session.solve_preview();
  session.set("u", 3);
  CHECK(session.solve_preview().superposed);
  const Points answered = session.dofs();
  session.solve_to_equilibrium();
  CHECK((answered - session.dofs()).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE(
    "an unconverged update keeps its own equations when something is added, and is undone whole",
    "[sculpting][session]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Load{"p", Load::Pressure{}});
  session.add(LineOffset{"m", "rib", {}, 0.3});
  const Points good = session.dofs();
  session.set("m", 0.05);
  session.set("p", 5);
  CHECK_FALSE(session.solve_preview(1).converged);
  CHECK(session.residual() < 1e-12);
  session.add(Load{"u", Load::Uniform{{0, 0, 1}}});
  CHECK(session.residual() < 1e-12);
  session.set("p", 1e9);
  CHECK_THROWS_AS(session.solve_to_equilibrium(), NoSolutionError);
  CHECK(session.parameters().value("m") == 0);
  CHECK(session.residual() < 1e-12);
  CHECK((session.dofs() - good).cwiseAbs().maxCoeff() == 0);
}

TEST_CASE("after a failed update parameters are in their ranges and rules hold",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Load{"p", Load::Pressure{}});
  session.solve_to_equilibrium();
  session.add_parameter({.name = "q", .value = 3, .min = 1, .max = 10});
  session.add(Load{"r", Load::Uniform{{0, 0, 1}}}, {{.name = "r", .value = 2, .min = 1, .max = 5}});
  session.set("p", 1e9);
  CHECK_THROWS_AS(session.solve_to_equilibrium(), NoSolutionError);
  CHECK(session.parameters().value("p") == 0);
  CHECK(session.parameters().value("q") == 3);
  CHECK(session.parameters().value("r") == 1);
  session.set_rule("r", {{"q", 1}}, 0);
  session.set("p", 1e9);
  CHECK_THROWS_AS(session.solve_to_equilibrium(), NoSolutionError);
  CHECK(session.parameters().value("r") == session.parameters().value("q"));
  CHECK(session.solve_to_equilibrium().converged);
}

TEST_CASE("a limit load far below the given value is found", "[sculpting][session]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add(Load{"p", Load::Pressure{}});
  const auto reached = [&](double asked) {
    session.set("p", asked);
    try {
      session.solve_to_equilibrium();
    } catch (const NoSolutionError& e) {
      const std::string text = e.what();
      return std::stod(text.substr(text.find('(') + 1));
    }
    return asked;
  };
  const double near = reached(1e4), far = reached(1e9);
  CHECK(near > 1);
  CHECK(near < 1e4);
  CHECK(far == Approx(near).epsilon(0.02));
}

TEST_CASE("springs with a falloff have a potential: energy falls in motion",
          "[sculpting][session]") {
  SculptingSession session(square_layout(0.2), {});
  session.add(springs("k", 0.2), {{.name = "k", .value = 2000}});
  session.start_motion({.dt = 1e-4, .density = 1, .damping = 0, .theta = 1});
  double before = session.total_energy();
  const double start = before;
  for (int i = 0; i < 400; ++i) {
    session.step();
    const double now = session.total_energy();
    CHECK(now <= before + 1e-9 * start);
    before = now;
  }
  CHECK(before < start);
}

TEST_CASE("a normal's name takes no parameter of another away, and rest at rest costs no redo",
          "[sculpting][session]") {
  SculptingSession session(patch_layout(0.2), {});
  session.add_parameter({.name = "foo.x", .value = 1});
  session.add(Constraint{"foo", Constraint::Normal{{0.3, 0.3, 0.1}, {0, 0.1, 1}}});
  session.remove("foo");
  CHECK(session.parameters().has("foo.x"));
  session.undo();
  session.stop_motion();
  CHECK(session.redo());
}

TEST_CASE("a session replays its own record while it records", "[sculpting][session]") {
  SculptingSession session(patch_layout(0.2), {});
  session.record(true);
  session.add(Load{"p", Load::Pressure{}});
  for (int i = 0; i < 20; ++i) {
    session.set("p", 0.1 * i);
    session.solve_preview();
  }
  const size_t done = session.recorded().size();
  session.replay(session.recorded());  // the load exists already: this operation is rejected
  CHECK(session.recorded().size() == 2 * done);
}
