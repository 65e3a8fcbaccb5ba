// SPDX-License-Identifier: MPL-2.0
// Refinement of the elements of a shell to an accuracy: true errors, estimates, singular stresses.
#include <cmath>

#include "batten/analysis/models/parent_triangles.h"
#include "batten/batten.h"
#include "batten/scenes/model_data.h"
#include "batten/tests/support/catch.h"

namespace batten::stress_accuracy {
namespace {

/// A plane face with straight sides "0", "1", ….
Model polygon(const std::vector<Vec3>& corners, const std::string& unit, double edge_length = 0) {
  std::vector<InputLine> sides;
  for (size_t k = 0; k < corners.size(); ++k)
    sides.push_back({std::to_string(k), {corners[k], corners[(k + 1) % corners.size()]}});
  return skin(sides, {.unit = unit, .edge_length = edge_length});
}

}  // namespace

TEST_CASE("the error of a skew plate with singular corners is below the accuracy, and estimated",
          "[scenes][stress]") {
  // NAFEMS LE6: simply supported, angle of 30 degrees.
  const double c = std::sqrt(0.75), s = 0.5, reference = 1.485e-5;
  const Model plate = polygon({{0, 0, 0}, {1, 0, 0}, {1 + c, s, 0}, {c, s, 0}}, "m");
  StressSettings settings{.young = 210e9, .poisson = 0.3, .thickness = 0.01};
  for (const char* side : {"0", "1", "2", "3"})
    settings.supports.push_back(
        {.curve = side, .type = "prescribed", .directions = {Vec3::UnitZ()}, .rotation = false});
  settings.supports.push_back(
      {.point = Vec3(0.5, 0.1, 0), .directions = {Vec3::UnitX(), Vec3::UnitY()}});
  settings.supports.push_back({.point = Vec3(1.2, 0.1, 0), .directions = {Vec3::UnitY()}});
  settings.loads = {{.traction = Vec3(0, 0, -700)}};
  CHECK(std::abs(stress(plate, settings).load_case().max_displacement / reference - 1) > 0.1);
  for (const double accuracy : {0.03, 0.01}) {
    settings.accuracy = accuracy;
    const Stress found = stress(plate, settings);
    const StressCase one = found.load_case();
    const double error = std::abs(one.max_displacement / reference - 1),
                 estimate = one.max_displacement_error / one.max_displacement;
    CHECK(found.failed_checks().empty());
    CHECK(error < accuracy);
    CHECK(estimate < 2 * error);
    CHECK(estimate > 0.5 * error);
    // The obtuse corners are singular; the largest stress elsewhere is that in the middle.
    CHECK(one.singular_places.size() >= 2);
    CHECK((one.stress_at - Vec3((1 + c) / 2, s / 2, 0)).norm() < 0.1);
  }
}

TEST_CASE("the largest stress of a plate under a point force is that at a distance, and converges",
          "[scenes][stress]") {
  const Model plate = polygon({{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}}, "mm", 20);
  const Vec3 middle(50, 50, 0);
  StressSettings settings{
      .material = "steel",
      .thickness = 1,
      .supports = {{.curve = "0"}, {.curve = "1"}, {.curve = "2"}, {.curve = "3"}},
      .loads = {{.force = Vec3(0, 0, -20), .point = middle}}};
  CHECK(stress(plate, settings).load_case().near_singularity);
  std::vector<double> found;
  for (const double accuracy : {0.02, 0.005}) {
    settings.accuracy = accuracy;
    const StressCase one = stress(plate, settings).load_case();
    CHECK_FALSE(one.near_singularity);
    REQUIRE(one.singular_places.size() == 1);
    const StressSingularity& place = one.singular_places[0];
    CHECK((place.at - middle).norm() < 1e-9);
    CHECK(place.radius > 10);
    CHECK(place.radius < 30);
    CHECK((one.stress_at - middle).norm() >= place.radius);
    found.push_back(one.max_von_mises);
  }
  CHECK(found[1] == Approx(found[0]).epsilon(0.03));
}

TEST_CASE("bisections of triangles lie in them, as often as requested", "[scenes][stress]") {
  const Model plate = polygon({{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}}, "mm", 25);
  const ModelLayout& before = *plate.data().shape.layout;
  std::vector<int> levels(static_cast<size_t>(before.mesh()->triangle_count()), 0);
  levels[3] = 4;
  const ModelLayout after = bisected(before, levels);
  const std::vector<int> parents = ParentTriangles(before).of_all(after);
  std::vector<double> areas(levels.size(), 0), smallest(levels.size(), 1e300);
  for (int t = 0; t < after.mesh()->triangle_count(); ++t) {
    const auto parent = static_cast<size_t>(parents[static_cast<size_t>(t)]);
    const double area = after.mesh()->shape(t).area;
    areas[parent] += area;
    smallest[parent] = std::min(smallest[parent], area);
  }
  for (int t = 0; t < before.mesh()->triangle_count(); ++t)
    CHECK(areas[static_cast<size_t>(t)] == Approx(before.mesh()->shape(t).area).epsilon(1e-12));
  CHECK(smallest[3] <= before.mesh()->shape(3).area / 16 * (1 + 1e-9));
  CHECK(bisected(before, std::vector<int>(levels.size(), 0)).mesh()->triangle_count() ==
        before.mesh()->triangle_count());
}

}  // namespace batten::stress_accuracy
