// SPDX-License-Identifier: MPL-2.0
// fit_surface() and motion of <batten/batten.h>: the results of the commands fit and sculpt --time.
#include <cmath>
#include <filesystem>

#include "batten/batten.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/model_data.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A cylinder patch of quads with four free edges, radius 10, opening angle 90 degrees.
Mesh quarter_pipe() {
  constexpr int n = 12;
  std::vector<Vec3> points;
  std::vector<std::vector<int>> faces;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double angle = M_PI / 2 * i / n;
      points.emplace_back(10 * std::cos(angle), 20.0 * j / n, 10 * std::sin(angle));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      faces.push_back({a, a + 1, a + n + 2, a + n + 1});
    }
  return Mesh(points, faces);
}

/// Dofs of the model that batten fit makes.
Points fitted_by_command(const std::filesystem::path& file, double tolerance) {
  Scene scene = scene_of_target(file, {}, "mm");
  scene.targets.front().tolerance = tolerance;
  return detail::ModelData("", std::move(scene), {}).shape.dofs;
}

}  // namespace

TEST_CASE("fit_surface() of a file and of its mesh is the model of batten fit", "[scenes][fit]") {
  const auto file = std::filesystem::temp_directory_path() / "batten_test_fit_surface.obj";
  quarter_pipe().save(file);
  FitSettings settings;
  settings.fit_tolerance = 0.05;
  const Model of_file = fit_surface(file, settings);
  const Points dofs = of_file.data().shape.dofs;
  CHECK(dofs == fitted_by_command(file, 0.05));
  CHECK(dofs == fit_surface(read_mesh(file), settings).data().shape.dofs);
  std::filesystem::remove(file);
  const auto& target = of_file.data().report({}).target;
  REQUIRE(target);
  CHECK(target->max < 0.05);
  CHECK(target->back_max < 0.05);
  CHECK(of_file.failed_checks().empty());
}

TEST_CASE("fit_surface() refuses invalid settings by name", "[scenes][fit]") {
  const Mesh mesh = quarter_pipe();
  CHECK_THAT(error_message([&] { fit_surface(mesh, {.fit_tolerance = -1}); }),
             Contains("fit_tolerance: found -1"));
  CHECK_THAT(error_message([&] { fit_surface(mesh, {.unit = "mn"}); }), Contains("'mn'"));
  CHECK_THAT(error_message([&] { fit_surface("missing.obj"); }), Contains("missing.obj"));
  CHECK_THAT(error_message([&] {
               fit_surface(mesh, {.curves = {{"a", {{0, 0, 0}}}}});
             }),
             Contains("curve 'a': found 1 points"));
}

TEST_CASE("a motion without damping keeps its energy, and damping reduces it", "[scenes][motion]") {
  const Model model = skin({{"front", {{0, 0, 0}, {1, 0, 0}}},
                            {"right", {{1, 0, 0}, {1, 1, 0.2}}},
                            {"back", {{1, 1, 0.2}, {0, 1, 0}}},
                            {"left", {{0, 1, 0}, {0, 0, 0}}}},
                           {.edge_length = 0.2});
  Session session(model);
  session.add_force("push", {0.5, 0.5, 0}, {0, 0, 1}, {.value = 2});
  session.solve();
  session.set("push", 0);
  session.start_motion({.dt = 0.002, .density = 1, .damping = 0, .theta = 0.5});
  CHECK(session.in_motion());
  session.step();  // the force ends during this step
  const double energy = session.total_energy();
  CHECK(energy > 0);
  double largest = 0, elastic = session.energy();
  for (int i = 0; i < 100; ++i) {
    session.step(2);
    largest = std::max(largest, std::abs(session.total_energy() / energy - 1));
    elastic = std::min(elastic, session.energy());
  }
  CHECK(largest < 1e-9);
  CHECK(elastic < 0.5 * energy);  // the other part is kinetic
  CHECK(session.time() == Approx(201 * 0.002));
  session.start_motion({.dt = 0.002, .density = 1, .damping = 5, .theta = 0.5});
  double before = session.total_energy();
  for (int i = 0; i < 50; ++i) {
    session.step();
    CHECK(session.total_energy() < before);
    before = session.total_energy();
  }
  session.stop_motion();
  CHECK_FALSE(session.in_motion());
  CHECK_THAT(error_message([&] { session.step(); }), Contains("start the motion first"));
  CHECK_THAT(error_message([&] { session.step(0); }), Contains("count: found 0"));
  CHECK_THAT(error_message([&] { session.start_motion(-1); }), Contains("time step -1"));
}
