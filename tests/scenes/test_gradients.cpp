// SPDX-License-Identifier: MPL-2.0
// Gradients with respect to the parameters of a model, against differences of whole models.
#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "batten/batten.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using batten_test::error_message;
using Catch::Contains;

namespace {

/// A vault with a pressure, a curve offset, a point that is moved, a parameter that drives, and a
/// stiffness.
Model variable_vault() {
  SkinSettings settings{.name = "vault", .edge_length = 25};
  settings.settings = R"(
[skin]
alpha = 0.5
beta = 1.0

[[load]]
name = "swell"
type = "pressure"
value = 2
min = -50
max = 50

[[offset]]
name = "lift"
curve = "front"
direction = [0, 0, 1]
value = 1
min = -5
max = 20

[[load]]
name = "nudge"
type = "point"
at = [30, 60, 10]
direction = [0, 0, 1]
value = 20
min = 0
max = 500
)";
  return skin({{"front", {{0, 0, 0}, {50, 0, 15}, {100, 0, 0}}},
               {"right", {{100, 0, 0}, {100, 100, 0}}},
               {"back", {{100, 100, 0}, {50, 100, 15}, {0, 100, 0}}},
               {"left", {{0, 100, 0}, {0, 0, 0}}}},
              settings);
}

StressSettings clamped_steel() {
  return {.material = "steel",
          .thickness = 1,
          .supports = {{.curve = "left"}, {.curve = "right", .type = "pinned"}},
          .loads = {{.pressure = -0.01},
                    {.force = Vec3(0, 0, -20), .point = Vec3(50, 50, 27), .load_case = "push"}}};
}

double step_of(const std::string& parameter) { return parameter == "nudge" ? 0.05 : 0.002; }

/// Central difference of a quantity of the model with another value of a parameter.
double difference(const Model& model, const std::string& parameter,
                  const std::function<double(const Model&)>& quantity) {
  const double h = step_of(parameter), value = model.parameters().at(parameter);
  return (quantity(model.with_values({{parameter, value + h}})) -
          quantity(model.with_values({{parameter, value - h}}))) /
         (2 * h);
}

}  // namespace

TEST_CASE("gradients of area equal differences of models", "[scenes][gradients]") {
  const Model model = variable_vault();
  const ModelGradients gradients = model.gradients();
  CHECK(gradients.area.value == model.area());
  CHECK_FALSE(gradients.volume);
  for (const auto& [name, value] : model.parameters()) {
    CAPTURE(name);
    REQUIRE(gradients.area.gradient.count(name) == 1);
    CHECK(gradients.area.gradient.at(name) ==
          Approx(difference(model, name, [](const Model& m) { return m.area(); }))
              .epsilon(1e-4)
              .margin(1e-4));
  }
}

TEST_CASE("gradients of stresses equal differences of analyses", "[scenes][gradients]") {
  const Model model = variable_vault();
  const Stress here = stress(model, clamped_steel());
  for (const std::string load_case : {"loads", "push"}) {
    const StressGradients gradients = here.gradients(6, load_case);
    CHECK(gradients.max_displacement.value == here.load_case(load_case).max_displacement);
    CHECK(gradients.mass.value == Approx(model.area() * 7.85e-9).epsilon(1e-6));
    for (const auto& [name, value] : model.parameters()) {
      CAPTURE(load_case, name);
      const auto check = [&](const ValueWithGradient& of,
                             const std::function<double(const StressGradients&)>& quantity) {
        const double expected = difference(model, name, [&](const Model& m) {
          return quantity(stress(m, clamped_steel()).gradients(6, load_case));
        });
        CHECK(of.gradient.at(name) ==
              Approx(expected).epsilon(1e-3).margin(1e-5 * std::abs(of.value)));
      };
      check(gradients.compliance, [](const auto& g) { return g.compliance.value; });
      check(gradients.von_mises_norm, [](const auto& g) { return g.von_mises_norm.value; });
      check(gradients.mass, [](const auto& g) { return g.mass.value; });
      check(gradients.max_displacement, [](const auto& g) { return g.max_displacement.value; });
    }
  }
}

TEST_CASE("gradients of a session's model know what was added to the session",
          "[scenes][gradients]") {
  Session session(variable_vault());
  session.add_pressure("wind", {.value = 1, .min = -10, .max = 10});
  session.add_point_constraint("pin", {50, 50, 15}, {50, 50, 20});
  session.solve();
  const Model model = session.model();
  const ModelGradients gradients = model.gradients();
  for (const std::string name : {"wind", "pin.z", "swell"}) {
    CAPTURE(name);
    CHECK(gradients.area.gradient.at(name) ==
          Approx(difference(model, name, [](const Model& m) { return m.area(); }))
              .epsilon(1e-4)
              .margin(1e-4));
  }
}

TEST_CASE("a stiffness has its derivative however weak its effect is", "[scenes][gradients]") {
  for (const double swell : {2.0, 0.02, 0.0005}) {
    const Model model =
        variable_vault().with_values({{"swell", swell}, {"lift", 0}, {"nudge", 0}, {"alpha", 0}});
    const ModelGradients gradients = model.gradients();
    CAPTURE(swell);
    const double expected = difference(model, "beta", [](const Model& m) { return m.area(); });
    CHECK(gradients.area.gradient.at("beta") == Approx(expected).epsilon(2e-3));
    // At its lower bound 0, alpha has a one-sided derivative.
    constexpr double h = 1e-4;
    const auto area = [&](double alpha) { return model.with_values({{"alpha", alpha}}).area(); };
    CHECK(gradients.area.gradient.at("alpha") ==
          Approx((4 * area(h) - area(2 * h) - 3 * area(0)) / (2 * h)).epsilon(5e-3));
  }
}

TEST_CASE("shapes that are not in equilibrium have no gradients", "[scenes][gradients]") {
  Session session(variable_vault());
  session.set("swell", 20);
  CHECK_THAT(error_message([&] { session.model().gradients(); }), Contains("not in equilibrium"));
  session.solve();
  CHECK(session.model().gradients().area.gradient.at("swell") > 0);
}

TEST_CASE("results under loads that boxes limit have no gradients", "[scenes][gradients]") {
  StressSettings settings = clamped_steel();
  settings.loads[0].box = Box3(Vec3(0, 0, -100), Vec3(50, 50, 100));
  const Stress boxed = stress(variable_vault(), settings);
  CHECK_THAT(error_message([&] { boxed.gradients(); }), Contains("load limited by a box"));
}

TEST_CASE("the stress norm of a face with a hole grows with its exponent", "[scenes][gradients]") {
  std::vector<Vec3> hole;
  for (int i = 0; i <= 24; ++i) {
    const double angle = 2 * 3.14159265358979323846 * i / 24;
    hole.emplace_back(50 + 16 * std::cos(angle), 50 + 9 * std::sin(angle), 0);
  }
  SkinSettings plate{.name = "plate", .edge_length = 20, .holes = {"hole"}};
  const Model model = skin(
      {{"rim", {{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}, {0, 0, 0}}}, {"hole", hole}},
      plate);
  const Stress bent = stress(model, {.material = "steel",
                                     .thickness = 1,
                                     .supports = {{.curve = "rim"}},
                                     .loads = {{.pressure = 0.01}}});
  double before = 0;
  for (const double exponent : {2.0, 8.0, 30.0, 100.0}) {
    const double norm = bent.gradients(exponent).von_mises_norm.value;
    CHECK(norm > before);
    before = norm;
  }
}

TEST_CASE("a callback of a long call may use the model", "[scenes][gradients]") {
  const Model model = variable_vault();
  int calls = 0;
  Progress progress;
  progress.report = [&](std::string_view, double) {
    ++calls;
    CHECK(!model.facets().points.empty());
    CHECK(!model.edges().empty());
  };
  CHECK(!model.gradients(progress).area.gradient.empty());
  CHECK(calls > 0);
}

TEST_CASE("the volume of a closed model has a gradient", "[scenes][gradients]") {
  // A tent over a square: four faces and a floor.
  const Vec3 top(0.5, 0.5, 0.7);
  const std::vector<Vec3> c = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<InputLine> curves;
  for (size_t i = 0; i < 4; ++i) {
    curves.push_back({"floor " + std::to_string(i), {c[i], c[(i + 1) % 4]}});
    curves.push_back({"ridge " + std::to_string(i), {c[i], top}});
  }
  SkinSettings settings{.name = "tent", .edge_length = 0.25};
  settings.settings =
      "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = 3\nmin = 0\nmax = 30\n";
  const Model model = skin(curves, settings);
  const ModelGradients gradients = model.gradients();
  REQUIRE(gradients.volume);
  CHECK(gradients.volume->value == model.volume());
  CHECK(gradients.volume->gradient.at("swell") > 0);
  CHECK(
      gradients.volume->gradient.at("swell") ==
      Approx(difference(model, "swell", [](const Model& m) { return m.volume(); })).epsilon(1e-4));
}

TEST_CASE("gradients refuse an exponent out of range and an unknown load case",
          "[scenes][gradients]") {
  const Stress here = stress(variable_vault(), clamped_steel());
  for (const double exponent : {1.0, 0.0, -1.0, std::nan(""), kInfinity})
    CHECK_THAT(error_message([&] { here.gradients(exponent); }), Contains("expected 2 to 100"));
  CHECK_THAT(error_message([&] { here.gradients(8, "pusch"); }), Contains("did you mean 'push'"));
}
