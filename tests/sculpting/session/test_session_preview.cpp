// SPDX-License-Identifier: MPL-2.0
// Updates after slider changes: superposition, solves, iterations.
#include "batten/constraints/constrained_solver.h"
#include "batten/core/errors.h"
#include "batten/skinning/facets/facets.h"
#include "batten/tests/support/allocations.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/session_scenes.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

// The patch with one load of every linear type; each slider at 0.
SculptingSession loaded_patch(double edge = 0.25) {
  SculptingSession session(patch_layout(edge), with_material(0.1, 1));
  session.add(Load{"uniform", Load::Uniform{{0, 0.3, 1}, {}}});
  session.add(Load{"near rib", Load::Uniform{{0, 0, 1}, {Area::NearLine{"rib", 0.5}}}});
  session.add(
      Load{"painted", Load::Uniform{{0, 0, -1}, {Area::Painted{{{{0.4, 0.6, 0.2}, 0.5, 1}}}}}});
  session.add(Load{"weight", Load::Gravity{{0, 0, -1}}});
  session.add(Load{"finger", Load::Point{{1.2, 0.6, 0.2}, {0.2, 0, 1}}});
  session.add(Load{"along rib", Load::Line{"rib", {0, 0, 1}}});
  session.solve_to_equilibrium();
  return session;
}

const std::vector<std::string> linear_loads = {"uniform", "near rib", "painted",
                                               "weight",  "finger",   "along rib"};

HermiteCurve ring_above(double height, double radius, const Vec2& middle) {
  std::vector<double> u;
  constexpr int n = 12;
  Points x(n + 1, 3), d(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = 2 * pi * i / n;
    u.push_back(t);
    x.row(i) << middle.x() + radius * std::cos(t), middle.y() + radius * std::sin(t), height;
    d.row(i) << -radius * std::sin(t), radius * std::cos(t), 0;
  }
  return {u, x, d};
}

}  // namespace

TEST_CASE("superposed sliders equal a full solve", "[sculpting][session]") {
  SculptingSession session = loaded_patch();
  Random random(3);
  int solves = 0;
  for (int n = 0; n < 40; ++n) {
    session.set(linear_loads[static_cast<size_t>(n) % linear_loads.size()], 3 * random());
    const SolveReport answer = session.solve_preview();
    CHECK(answer.superposed);
    CHECK(answer.converged);
    CHECK_FALSE(answer.factored);
    solves += answer.iterations;
  }
  CHECK(solves == static_cast<int>(linear_loads.size()));  // one each, at its first change
  const Points dragged = session.dofs();
  session.solve_to_equilibrium();
  const double moved = difference(session.dofs(), loaded_patch().dofs());
  CHECK(moved > 0.005);
  CHECK(difference(dragged, session.dofs()) < 1e-12);
}

TEST_CASE("loads of every linear kind are those of an independent assembly",
          "[sculpting][session]") {
  SculptingSession session = loaded_patch();
  const ModelLayout& layout = session.layout();
  const Matrices matrices(layout, SurfaceStiffness::isotropic(0.1, 1));
  const double size = layout.size();
  const Surface unloaded = shape_of(session);
  const auto solved = [&](const Points& F) {
    return solve_constrained(layout.line_constraints(), matrices.K, F);
  };
  const auto answered = [&](const std::string& load, double value) {
    session.set(load, value);
    session.solve_to_equilibrium();
    const Points x = session.dofs();
    session.set(load, 0);
    return x;
  };
  const Points uniform = solved(matrices.assembler.load(Vec3(2 * size * Vec3(0, 0.3, 1))));
  CHECK(difference(answered("uniform", 2), uniform) < 1e-10);
  const auto foot = unloaded.closest_point({1.2, 0.6, 0.2});
  const Points finger =
      solved(matrices.assembler.point_load(foot.where, 0.5 * size * Vec3(0.2, 0, 1)));
  CHECK(difference(answered("finger", 0.5), finger) < 1e-9);
  // Weight: proportional to the area without loads in each part.
  const Points weight = solved(matrices.assembler.load(
      [&](const Location& where, const Vec2&) {
        return Vec3(0, 0, -3 * unloaded.jet(where).area_vector().norm() / size);
      },
      8));
  CHECK(difference(answered("weight", 3), weight) < 1e-4 * difference(weight, unloaded.dofs()));
}

TEST_CASE("one parameter drives several by rules", "[sculpting][session]") {
  SculptingSession session = loaded_patch();
  session.add_parameter(slider("effect"));
  session.set_rule("uniform", {{"effect", 2}}, 0.5);
  session.set_rule("finger", {{"effect", -1}, {"uniform", 0.1}}, 0);
  session.set("effect", 1.5);
  session.solve_to_equilibrium();
  CHECK(session.parameters().value("uniform") == Approx(3.5));
  CHECK(session.parameters().value("finger") == Approx(-1.5 + 0.35));
  const Points driven = session.dofs();
  SculptingSession reference_session = loaded_patch();
  reference_session.set("uniform", 3.5);
  reference_session.set("finger", -1.15);
  reference_session.solve_to_equilibrium();
  CHECK(difference(driven, reference_session.dofs()) < 1e-12);
  CHECK_THROWS_AS(session.set("finger", 1), InputError);
  CHECK_THROWS_AS(session.set_rule("effect", {{"finger", 1}}, 0), InputError);
}

TEST_CASE("sliders, updates, steps and frames allocate no memory", "[sculpting][session]") {
  if (!counts_allocations()) return;
  SculptingSession session = loaded_patch();
  session.add(Load{"pressure", Load::Pressure{}});
  session.add(Constraint{"pin", Constraint::Point{{0.5, 0.7, 0.2}, {0.5, 0.7, 0.3}}});
  session.add(LineOffset{"raise", "rib", Vec3(0, 0, 1), 0.2});
  const int uniform = session.parameters().index("uniform"),
            pressure = session.parameters().index("pressure"),
            pin = session.parameters().index("pin.z"), raise = session.parameters().index("raise");
  const auto drag = [&](int parameter, double from, double to) {
    session.set(parameter, from);
    session.solve_preview();
    session.set(parameter, 0.5 * (from + to));
    session.solve_preview();
    session.frame();
    const ScopedOpCount work;
    for (int n = 0; n <= 10; ++n) {
      session.set(parameter, from + (to - from) * n / 10);
      session.solve_preview();
      session.frame();
    }
    return work.of(OpCounter::Allocation);
  };
  CHECK(drag(uniform, 0, 1) == 0);
  CHECK(drag(pin, 0.3, 0.35) == 0);
  CHECK(drag(raise, 0, 0.05) == 0);
  CHECK(drag(pressure, 0, 5) == 0);
  session.start_motion({.dt = 0.01});
  session.step();
  session.step();
  session.frame();
  const ScopedOpCount work;
  for (int n = 0; n < 10; ++n) {
    session.step();
    session.frame();
  }
  CHECK(work.of(OpCounter::Allocation) == 0);
}

TEST_CASE("frames show the current surface, and report changes", "[sculpting][session]") {
  for (const bool cut : {false, true}) {
    SculptingSession session(cut ? disc_layout(0.3) : patch_layout(0.3), {});
    session.add(Load{"f", Load::Uniform{{0.2, 0, 1}, {}}});
    DisplayFacets all;
    const auto remeshed = [&](const Frame& frame) {
      all = facets(session.region(), 2);
      CHECK(frame.remeshed);
      CHECK(frame.moved);
      CHECK(frame.pattern->facets == all.tessellation.facets);
      CHECK(frame.pattern->lines == all.lines);
    };
    const auto shows_it = [&](const Frame& frame) {
      const Surface surface = shape_of(session);
      REQUIRE(frame.points.size() == 3 * all.tessellation.points.size());
      double worst = 0;
      for (size_t i = 0; i < all.tessellation.points.size(); ++i) {
        const SurfaceJet jet = surface.jet(all.tessellation.points[i]);
        for (int c = 0; c < 3; ++c) {
          const size_t k = 3 * i + static_cast<size_t>(c);
          worst = std::max({worst, std::abs(static_cast<double>(frame.points[k]) - jet.x[c]),
                            std::abs(static_cast<double>(frame.normals[k]) - jet.normal()[c])});
        }
      }
      CHECK(worst < 5e-6);
    };
    const Frame& first = session.frame();
    remeshed(first);
    shows_it(first);
    const long number = first.number;
    const Frame& same = session.frame();
    CHECK_FALSE(same.moved);
    CHECK_FALSE(same.remeshed);
    CHECK(same.number == number + 1);
    session.set("f", 20);
    CHECK_FALSE(session.frame().moved);  // not solved yet
    session.solve_preview();
    const Frame& moved = session.frame();
    CHECK(moved.moved);
    CHECK_FALSE(moved.remeshed);
    shows_it(moved);
    session.refine({Refinement::JumpIndicator{0.3}});
    const Frame& refined = session.frame();
    remeshed(refined);
    shows_it(refined);
    session.undo();
    const Frame& undone = session.frame();
    remeshed(undone);
    shows_it(undone);
  }
}

TEST_CASE("the same bits on one thread or two", "[sculpting][session]") {
  const auto run = [](int threads) {
    const ThreadGuard guard(threads);
    SculptingSession session(disc_layout(0.2), with_material(0.1, 1));
    session.add(Load{"p", Load::Pressure{}}, {slider("p", 2)});
    session.add(Constraint{"pin", Constraint::Point{{0.3, 0.1, 0}, {0.3, 0.1, 0.1}}});
    session.solve_to_equilibrium();
    session.set("pin.z", 0.2);
    session.solve_preview();
    session.refine({Refinement::JumpIndicator{}});
    session.start_motion({.dt = 0.01});
    for (int n = 0; n < 5; ++n) session.step();
    const Frame& frame = session.frame();
    return std::tuple(session.dofs(), frame.points, frame.normals);
  };
  const auto [one, one_points, one_normals] = run(1);
  const auto [two, two_points, two_normals] = run(2);
  CHECK(same_bits(one, two));
  CHECK(one_points == two_points);
  CHECK(one_normals == two_normals);
}

TEST_CASE("the same loads, two minima: springs to a ring hold a sheet above it or below",
          "[sculpting][session]") {
  // Springs that weaken with distance attract the sheet to the closer of two circles.
  const auto settled_from = [](double start) {
    SculptingSession session(square_layout(0.15, 2), with_material(0, 1));
    std::vector<Vec3> feet;
    for (int i = 0; i < 12; ++i)
      feet.emplace_back(1 + 0.4 * std::cos(pi * i / 6), 1 + 0.4 * std::sin(pi * i / 6), 0);
    for (const double height : {0.4, -0.4}) {
      Load::AttractorSprings springs;
      springs.at = feet;
      springs.target = Load::AttractorSprings::Curve{ring_above(height, 0.4, {1, 1})};
      springs.falloff = 0.35;
      session.add(Load{height > 0 ? "upper" : "lower", springs}, {});
    }
    session.add(Load{"push", Load::Uniform{{0, 0, 1}, {}}}, {slider("push", start)});
    session.solve_to_equilibrium();
    session.set("upper", 60);
    session.set("lower", 60);
    session.solve_to_equilibrium();
    session.set("push", 0);
    session.start_motion({.dt = 0.01, .damping = 2});
    for (int n = 0; n < 600; ++n) session.step();
    session.stop_motion();
    REQUIRE(session.solve_to_equilibrium().converged);
    const Surface shape = shape_of(session);
    return std::pair(shape.position(shape.closest_point({1, 1, 0}).where).z(),
                     session.total_energy());
  };
  const auto [up, energy_up] = settled_from(60);
  const auto [down, energy_down] = settled_from(-60);
  INFO(up << " " << down << " " << energy_up << " " << energy_down);
  CHECK(up > 0.1);
  CHECK(down < -0.1);
  CHECK(energy_up == Approx(energy_down).epsilon(1e-6));  // mirror images of each other
}

TEST_CASE("alpha and beta are parameters, everywhere or in areas", "[sculpting][session]") {
  SculptingSession session = loaded_patch();
  session.set("uniform", 5);
  session.solve_to_equilibrium();
  const Points soft = session.dofs();
  session.set("beta", 10);
  session.set("alpha", 1);
  const SolveReport answer = session.solve_to_equilibrium();
  CHECK(answer.factored);
  const Points stiff = session.dofs();
  const Matrices matrices(session.layout(), SurfaceStiffness::isotropic(1, 10));
  const Points direct = solve_constrained(
      session.layout().line_constraints(), matrices.K,
      matrices.assembler.load(Vec3(5 * session.layout().size() * Vec3(0, 0.3, 1))));
  CHECK(difference(stiff, direct) < 1e-10);
  session.add(
      StiffnessField{"spine", StiffnessField::Kind::Bending, {Area::NearLine{"rib", 0.4}}, "rib"});
  session.solve_to_equilibrium();
  CHECK(difference(session.dofs(), stiff) < 1e-11);  // still 0
  session.set("spine", 100);
  CHECK(session.solve_to_equilibrium().factored);
  CHECK(difference(session.dofs(), stiff) > 1e-5);
  CHECK_THROWS_AS(session.set("beta", -1), InputError);
  session.set("beta", 1);
  session.set("alpha", 0.1);
  session.set("spine", 0);
  session.solve_to_equilibrium();
  CHECK(difference(session.dofs(), soft) < 1e-11);
}

TEST_CASE("invalid input is refused by name and changes nothing", "[sculpting][session]") {
  SculptingSession session = loaded_patch();
  const Points before = session.dofs();
  const auto names = session.names();
  CHECK_THROWS_WITH(session.set("unifrom", 1), Contains("uniform"));
  CHECK_THROWS_AS(session.set("uniform", NAN), InputError);
  CHECK_THROWS_WITH(session.add(Load{"uniform", Load::Pressure{}}), Contains("'uniform'"));
  CHECK_THROWS_WITH(session.add(Load{"far", Load::Point{{90, 0, 0}, {0, 0, 1}}}),
                    Contains("'far'"));
  CHECK_THROWS_AS(session.add(Load{"p", Load::Point{{NAN, 0, 0}, {0, 0, 1}}}), InputError);
  CHECK_THROWS_WITH(session.add(Load{"l", Load::Line{"rub", {0, 0, 1}}}), Contains("rub"));
  CHECK_THROWS_AS(session.add(Load{"", Load::Pressure{}}), InputError);
  CHECK_THROWS_AS(
      session.add(StiffnessField{
          "w", StiffnessField::Kind::Bending, {Area::Painted{{{{0, 0, 0}, -1, 1}}}}, {}}),
      InputError);
  CHECK_THROWS_WITH(session.remove("nothing"), Contains("'nothing'"));
  CHECK_THROWS_AS(session.solve_to_equilibrium().converged && (session.set(999, 1), true),
                  InputError);
  CHECK(session.names() == names);
  CHECK(difference(before, session.dofs()) < 1e-13);
}
