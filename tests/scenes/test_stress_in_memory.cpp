// SPDX-License-Identifier: MPL-2.0
// Stress analysis in memory: the results of `batten stress`, values at points, messages.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <thread>

#include "batten/batten.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/test_data.h"

using namespace batten;
using batten_test::error_message;
using Catch::Contains;

namespace {

/// A vault of 100 by 100, whose shape depends on a pressure.
Model vault() {
  SkinSettings settings{.name = "vault", .edge_length = 20};
  settings.settings = "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = 2\nmin = -50\n";
  return skin({{"front", {{0, 0, 0}, {50, 0, 15}, {100, 0, 0}}},
               {"right", {{100, 0, 0}, {100, 100, 0}}},
               {"back", {{100, 100, 0}, {50, 100, 15}, {0, 100, 0}}},
               {"left", {{0, 100, 0}, {0, 0, 0}}}},
              settings);
}

/// A plate with sides of 100 mm.
Model plate(const std::string& unit = "mm") {
  const double a = unit == "m" ? 0.1 : 100;
  SkinSettings settings{.name = "plate", .unit = unit, .edge_length = a / 5};
  return skin({{"front", {{0, 0, 0}, {a, 0, 0}}},
               {"right", {{a, 0, 0}, {a, a, 0}}},
               {"back", {{a, a, 0}, {0, a, 0}}},
               {"left", {{0, a, 0}, {0, 0, 0}}}},
              settings);
}

/// A steel shell with two load cases, clamped on the left and pinned on the right.
StressSettings steel() {
  return {.material = "steel",
          .thickness = 1,
          .yield_stress = 235,
          .supports = {{.curve = "left"}, {.curve = "right", .type = "pinned"}},
          .loads = {{.pressure = -0.01},
                    {.force = Vec3(0, 0, -20), .point = Vec3(50, 50, 15), .load_case = "push"}}};
}

Report run_of(const std::string& scene) {
  unsetenv("DISPLAY");  // no pictures
  setenv("BATTEN_XVFB", "", 1);
  const auto folder = batten_test::scratch("stress_in_memory");
  return run_stress(parse_scene(scene, folder / "scene.toml"), folder / "out", {.accuracy = 0});
}

double distance(const Vec3& a, const Vec3& b) { return (a - b).norm(); }

}  // namespace

TEST_CASE("a model and its scene have the same stresses, to the bit", "[scenes][stress]") {
  StressSettings settings = steel();
  settings.modes = 2;
  settings.buckling = 1;
  settings.settings =
      "sensitivities = true\n"
      "combinations = [{name = \"both\", cases = [\"loads\", \"push\"], factors = [1.35, 1.5]}]";
  const Stress in_memory = stress(vault(), settings);
  const Report report = run_of(in_memory.scene());
  CHECK(in_memory.report() == to_json(*report.stress));
  CHECK(in_memory.warnings() == report.warnings);
  REQUIRE(in_memory.cases().size() == 3);
  CHECK(in_memory.cases()[2].combination);
  CHECK(report.stress->sensitivities.size() >= 2);
  // The [stress] of a scene is that of its model.
  const Model model = parse(in_memory.scene());
  CHECK(stress(model).report() == in_memory.report());
  CHECK(stress(model).scene() == model.scene());
  // Settings replace it.
  const Stress other = stress(model, steel());
  CHECK(other.cases().size() == 2);
  CHECK(other.frequencies().empty());
  CHECK(stress(parse(other.scene())).report() == other.report());
}

TEST_CASE("live stresses with prescribed displacements and several cases are those of new analyses",
          "[scenes][stress]") {
  StressSettings settings = steel();
  settings.thickness = 0.1;
  settings.supports = {
      {.curve = "left"},
      {.box = Box3(Vec3(60, 30, -100), Vec3(90, 70, 100)), .displacement = Vec3(0, 0, 5)}};
  settings.loads[1].point = Vec3(30, 50, 15);
  Session session(vault());
  for (int k = 0; k < 5; ++k) {
    session.set("swell", 2 + 0.4 * k);
    session.solve();
    const SessionStress live = session.stress(settings);
    const Stress exact = stress(session.model(), settings);
    CHECK(live.load_case == exact.load_case().name);
    CHECK(live.max_von_mises == Approx(exact.max_von_mises()).epsilon(1e-6));
    CHECK(live.max_displacement == Approx(exact.max_displacement()).epsilon(1e-6));
  }
  // A call that is cancelled anywhere changes no later result.
  session.set("swell", 6);
  session.solve();
  const double expected = stress(session.model(), settings).max_von_mises();
  for (const int polls : {1, 3, 8, 20}) {
    int left = polls;
    Progress progress;
    progress.cancelled = [&] { return --left <= 0; };
    CHECK_THROWS_AS(session.stress(settings, progress), CancelledError);
    CHECK(session.stress(settings).max_von_mises == Approx(expected).epsilon(1e-6));
  }
  for (const auto set : {&StressSettings::modes, &StressSettings::buckling}) {
    StressSettings more = settings;
    more.*set = 2;
    CHECK_THAT(error_message([&] { session.stress(more); }), Contains("found 2, expected 0"));
  }
}

TEST_CASE("adaptive refinement in memory is that of the command", "[scenes][stress]") {
  StressSettings settings = steel();
  settings.accuracy = 0.02;
  const Model model = vault();
  const Stress accurate = stress(model, settings);
  unsetenv("DISPLAY");  // no pictures
  setenv("BATTEN_XVFB", "", 1);
  const auto folder = batten_test::scratch("stress_accuracy");
  StressTask task;
  task.accuracy = settings.accuracy;
  const Report report =
      run_stress(parse_scene(accurate.scene(), folder / "scene.toml"), folder / "out", task);
  CHECK(accurate.report() == to_json(*report.stress));
  CHECK(accurate.failed_checks().empty());
  CHECK(accurate.model().element_count() > model.element_count());
  CHECK(accurate.model().area() == Approx(model.area()).epsilon(1e-7));
  CHECK(accurate.von_mises().size() == accurate.model().facets().points.size() / 3);
  settings.accuracy = 10;  // the elements of the model are small enough
  CHECK(stress(model, settings).model().element_count() == model.element_count());
  for (const double wrong : {-1.0, std::nan(""), kInfinity}) {
    settings.accuracy = wrong;
    CHECK_THAT(error_message([&] { stress(model, settings); }), Contains("accuracy: found"));
  }
  settings.accuracy = 0.1;
  Session session(model);
  CHECK_THAT(error_message([&] { session.stress(settings); }), Contains("accuracy: found 0.1"));
}

TEST_CASE("variants of a model have the stresses of their scenes", "[scenes][stress]") {
  const Model model = vault();
  std::vector<double> most;
  for (const double swell : {-10.0, 0.0, 10.0}) {
    const Model variant = model.with_values({{"swell", swell}});
    const Stress found = stress(variant, steel());
    CHECK(stress(parse(variant.scene()), steel()).report() == found.report());
    most.push_back(found.max_displacement());
  }
  CHECK(most[0] != most[1]);
  Session session(model);
  session.set("swell", 10);
  session.solve();
  CHECK(stress(session.model(), steel()).max_displacement() == Approx(most[2]).epsilon(1e-6));
}

TEST_CASE("maxima, reactions and fields of a stress analysis agree", "[scenes][stress]") {
  const Model model = vault();
  const Stress found = stress(model, steel());
  CHECK(found.failed_checks().empty());
  for (const StressCase& c : found.cases()) {
    INFO(c.name);
    CHECK(found.max_von_mises() >= c.max_von_mises);
    CHECK(found.max_displacement() >= c.max_displacement);
    CHECK(c.safety_factor == Approx(235 / c.max_von_mises));
    CHECK(c.stress_face == model.faces().front());
    CHECK(c.displacement_face == model.faces().front());
    Vec3 sum = c.force;
    REQUIRE(c.reactions.size() == 2);
    CHECK(c.reactions[0].support == "clamped left");
    for (const ShellReaction& r : c.reactions) sum += r.force;
    CHECK(sum.norm() < 1e-7 * c.force.norm());

    const StressPoint moved = found.at(c.displacement_at, c.name);
    CHECK(distance(moved.displacement, c.displacement) < 1e-6 * c.max_displacement);
    CHECK(c.displacement.norm() == Approx(c.max_displacement));
    const StressPoint peak = found.at(c.stress_at, c.name);
    CHECK(peak.distance < 1e-6);
    CHECK((c.stress_side == "top" ? peak.von_mises_top : peak.von_mises_bottom) ==
          Approx(c.max_von_mises).epsilon(1e-6));

    const Facets& facets = model.facets();
    const std::vector<double>&stresses = found.von_mises(c.name),
          &moves = found.displacement(c.name);
    REQUIRE(3 * stresses.size() == facets.points.size());
    REQUIRE(moves.size() == facets.points.size());
    const std::vector<double> top = found.von_mises(c.name, "top"),
                              middle = found.von_mises(c.name, "middle"),
                              bottom = found.von_mises(c.name, "bottom");
    CHECK(*std::max_element(stresses.begin(), stresses.end()) >= 0.9 * c.max_von_mises);
    for (size_t i = 0; i < stresses.size(); i += 37) {
      const StressPoint p = found.at(Eigen::Map<const Vec3>(facets.points.data() + 3 * i), c.name);
      CHECK(std::max(p.von_mises_top, p.von_mises_bottom) ==
            Approx(stresses[i]).epsilon(1e-4).margin(1e-4 * c.max_von_mises));
      CHECK(std::max(top[i], bottom[i]) == stresses[i]);
      CHECK(p.von_mises_middle == Approx(middle[i]).margin(1e-4 * c.max_von_mises));
      CHECK(distance(p.displacement, Eigen::Map<const Vec3>(moves.data() + 3 * i)) <
            1e-6 * c.max_displacement);
      CHECK((p.forces * p.normal).norm() <= 1e-9 * p.forces.norm());
      CHECK((p.moments - p.moments.transpose()).norm() <= 1e-12 * p.moments.norm());
    }
  }
  const std::string& governing = found.load_case().name;
  CHECK(found.load_case().max_von_mises == found.max_von_mises());
  CHECK(found.von_mises() == found.von_mises(governing));
  CHECK(found.thickness() == std::vector<double>(found.von_mises().size(), 1.0));
  CHECK_THROWS_WITH(found.von_mises("", "topp"), Contains("side: ") && Contains("'top'"));
}

TEST_CASE("stresses and displacements are proportional to the loads", "[scenes][stress]") {
  StressSettings settings = steel();
  const Stress once = stress(vault(), settings);
  settings.loads[0].pressure = -0.02;
  const Stress twice = stress(vault(), settings);
  const StressCase &a = once.load_case("loads"), &b = twice.load_case("loads");
  CHECK(b.max_von_mises == Approx(2 * a.max_von_mises));
  CHECK(distance(b.displacement, 2 * a.displacement) < 1e-7 * b.max_displacement);
  CHECK(twice.load_case("push").max_von_mises == once.load_case("push").max_von_mises);
}

TEST_CASE("natural modes and buckling of a cantilever plate", "[scenes][stress]") {
  const Model model = plate();
  const Stress found = stress(model, {.material = "steel",
                                      .thickness = 1,
                                      .supports = {{.curve = "left"}},
                                      .loads = {{.force = Vec3(-1, 0, 0), .curve = "right"}},
                                      .modes = 2,
                                      .buckling = 1});
  // Of a square cantilever plate with ν = 0.3: 3.47 and 8.51 √(D/ρt)/2πL².
  const double unit = std::sqrt(210000.0 / (12 * 0.91) / 7.85e-9) / (2 * std::numbers::pi * 1e4);
  REQUIRE(found.frequencies().size() == 2);
  CHECK(found.frequencies()[0] == Approx(3.47 * unit).epsilon(0.01));
  CHECK(found.frequencies()[1] == Approx(8.51 * unit).epsilon(0.01));
  // Between Euler's load of a strip that is free to contract, and that of one that is not.
  const double euler = std::pow(std::numbers::pi, 2) * 210000.0 / 12 / (4 * 1e4);
  REQUIRE(found.load_case().buckling_factors.size() == 1);
  CHECK(found.load_case().buckling_factors[0] > 0.97 * euler);
  CHECK(found.load_case().buckling_factors[0] < euler / 0.91);
  for (const std::vector<double>& shape : {found.mode_shape(0), found.buckling_shape(0)}) {
    REQUIRE(shape.size() == model.facets().points.size());
    double largest = 0, along_z = 0;
    for (size_t i = 0; i < shape.size(); i += 3) {
      largest = std::max(largest, Eigen::Map<const Vec3>(shape.data() + i).norm());
      along_z = std::max(along_z, std::abs(shape[i + 2]));
    }
    CHECK(largest == Approx(1).epsilon(0.01));
    CHECK(along_z == Approx(1).epsilon(0.01));
  }
  CHECK_THROWS_WITH(found.mode_shape(2), Contains("expected 0 to 1"));
  // A plate without membrane forces does not buckle.
  StressSettings bent = steel();
  bent.loads = {{.pressure = 1}};
  bent.buckling = 1;
  const Stress flat = stress(model, bent);
  CHECK(flat.load_case().buckling_factors.empty());
  CHECK_THROWS_WITH(flat.buckling_shape(0), Contains("a load under which the shell buckles"));
  CHECK_THROWS_WITH(flat.mode_shape(0), Contains("'modes' above 0"));
}

TEST_CASE("the same plate in m and in mm has the same stresses in memory", "[scenes][stress]") {
  const auto settings = [](double length, double gravity) {
    return StressSettings{.material = "steel",
                          .thickness = length,
                          .supports = {{.curve = "left"}},
                          .loads = {{.gravity = Vec3(0, 0, -gravity)}}};
  };
  const Stress mm = stress(plate(), settings(1, 9810)),
               m = stress(plate("m"), settings(1e-3, 9.81));
  CHECK(m.max_von_mises() == Approx(1e6 * mm.max_von_mises()).epsilon(1e-6));
  CHECK(m.max_displacement() == Approx(1e-3 * mm.max_displacement()).epsilon(1e-6));
  CHECK_THROWS_WITH(
      stress(plate(), {.young = 210e9, .thickness = 1, .supports = {{.curve = "left"}}}),
      Contains("expected N/mm²"));
}

TEST_CASE("supports and loads of every kind are those of a scene", "[scenes][stress]") {
  const Model model = plate();
  const Box3 corner(Vec3(-1, -1, -1), Vec3(30, 30, 1));
  const std::string face = model.faces().front();
  const Stress found =
      stress(model, {.young = 70e3,
                     .poisson = 0.2,
                     .density = 2.7e-9,
                     .thickness = 2,
                     .supports = {{.curve = "left", .type = "symmetric", .normal = Vec3(1, 0, 0)},
                                  {.curve = "front",
                                   .type = "prescribed",
                                   .directions = {{0, 1, 0}, {0, 0, 1}},
                                   .rotation = true,
                                   .displacement = Vec3(0, 0, 0.1)},
                                  {.point = Vec3(100, 100, 0), .directions = {{0, 0, 1}}},
                                  {.box = corner},
                                  {.curve = "right", .spring = Vec3(0, 0, 10)},
                                  {.face = face, .foundation = 0.05}},
                     .loads = {{.pressure = -0.01, .face = face, .box = corner},
                               {.traction = Vec3(0.01, 0, 0)},
                               {.gravity = Vec3(0, 0, -9810)},
                               {.hydrostatic = 1e-4, .level = 5},
                               {.moment = 2, .curve = "back"},
                               {.edge_force = 3, .curve = "back", .load_case = "edge"},
                               {.total_force = Vec3(0, 0, 40),
                                .total_moment = Vec3(100, 0, 0),
                                .face = face,
                                .load_case = "total"},
                               {.angular_velocity = 10, .axis = Vec3(0, 0, 1)},
                               {.force = Vec3(0, 1, 0), .curve = "back", .load_case = "pull"}}});
  CHECK(found.cases().size() == 4);
  CHECK(found.load_case("loads").reactions.size() == 6);
  CHECK((found.load_case("edge").force - Vec3(0, 300, 0)).norm() < 1e-9);
  CHECK((found.load_case("total").force - Vec3(0, 0, 40)).norm() < 1e-9);
  CHECK(found.load_case("pull").force[1] == Approx(100));
  CHECK(stress(parse(found.scene())).report() == found.report());
}

TEST_CASE("messages of a stress analysis name the setting", "[scenes][stress]") {
  const Model model = vault();
  const auto refused = [&](const auto& change) {
    StressSettings settings = steel();
    change(settings);
    return error_message([&] { stress(model, settings); });
  };
  CHECK_THAT(refused([](auto& s) { s.supports[1].curve = "rihgt"; }),
             Contains("stress(): supports[1]: found the curve 'rihgt'") &&
                 Contains("did you mean 'right'"));
  CHECK_THAT(refused([](auto& s) { s.supports[0].type = "clampd"; }),
             Contains("stress(): supports[0]: ") && Contains("did you mean 'clamped'"));
  CHECK_THAT(refused([](auto& s) { s.loads[1].point = Vec3(0, 0, 900); }),
             Contains("stress(): loads[1]: found a point at a distance"));
  CHECK_THAT(refused([](auto& s) { s.loads[1].point.reset(); }),
             Contains("stress(): loads[1]: found 'force' without a location"));
  CHECK_THAT(refused([](auto& s) { s.loads[0].pressure = std::nan(""); }),
             Contains("stress(): loads[0].pressure: found nan"));
  CHECK_THAT(refused([](auto& s) { s.material = "stel"; }),
             Contains("stress(): material: ") && Contains("did you mean 'steel'"));
  CHECK_THAT(refused([](auto& s) { s.thickness = 0; }), Contains("stress(): found no 'thickness'"));
  CHECK_THAT(refused([](auto& s) { s.supports.clear(); }),
             Contains("stress(): found no supports, expected one or more"));
  CHECK_THAT(refused([](auto& s) { s.settings = "\nhinges = [\"lid\"]"; }),
             Contains("stress(): settings:2:11: found the curve 'lid'"));
  CHECK_THAT(refused([](auto& s) { s.settings = "[mesh]\nedge_length = 1"; }),
             Contains("settings: found the table 'mesh'"));
  CHECK_THAT(error_message([&] { stress(model); }), Contains("vault: found no [stress]"));
  const Stress found = stress(model, steel());
  CHECK_THROWS_WITH(found.load_case("pusch"), Contains("did you mean 'push'"));
  CHECK_THROWS_WITH(found.at({0, 0, 0}, "pusch"), Contains("did you mean 'push'"));
}

TEST_CASE("an analysis without enough supports names the free motions", "[scenes][stress]") {
  StressSettings settings = steel();
  settings.supports = {{.foundation = 1}};
  CHECK_THROWS_AS(stress(plate(), settings), NoSolutionError);
  CHECK_THROWS_WITH(stress(plate(), settings),
                    Contains("the whole model can translate along [1, 0, 0]"));
  settings.supports = {{.point = Vec3(0, 0, 0)}};
  CHECK_THROWS_WITH(stress(plate(), settings), Contains("the whole model can rotate"));
}

TEST_CASE("a stress analysis may be evaluated by several threads, and cancelled",
          "[scenes][stress]") {
  const Model model = vault();
  const Stress found = stress(model, steel()), same = stress(model, steel());
  std::vector<std::vector<double>> fields(4);
  std::vector<std::thread> threads;
  for (std::vector<double>& field : fields)
    threads.emplace_back([&] { field = found.von_mises("push"); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& field : fields) CHECK(field == same.von_mises("push"));
  CHECK_THROWS_AS(stress(model, steel(), {{}, [] { return true; }}), CancelledError);
}
