// SPDX-License-Identifier: MPL-2.0
// Holes remove the surface: inner curves end at their boundaries, and trim-only holes do not change
// the shape.
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/primitive_curves.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using Role = CharacterLine::Role;
using Domain = SkinOptions::Domain;

namespace {

CharacterLine line(const std::string& name, Role role, const std::vector<Vec3>& points) {
  return {name, curve_through_points(name, points, 20), role};
}

CharacterLine circle(const std::string& name, const Vec3& centre, double radius) {
  return {
      name,
      ellipse_arc({centre, Vec3::UnitX(), Vec3::UnitY()}, radius, radius, 0, 2 * std::numbers::pi),
      Role::Hole};
}

// A flat sheet of 4 × 2 with a curve along its middle.
std::vector<CharacterLine> sheet() {
  return {line("rim", Role::Outline, {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}, {0, 0, 0}}),
          line("middle", Role::Inner, {{0, 1, 0}, {4, 1, 0}})};
}

SkinOptions coarse() {
  SkinOptions options;
  options.edge_length = 0.25;
  return options;
}

std::vector<std::string> inner_names(const RegionLayout& layout) {
  std::vector<std::string> names;
  for (const EdgeAlignedLine& aligned_line : layout.edge_aligned())
    if (aligned_line.line.role == Role::Inner) names.push_back(aligned_line.line.name);
  for (const EmbeddedLine& e : layout.embedded())
    if (e.line.role == Role::Inner) names.push_back(e.line.name);
  std::sort(names.begin(), names.end());
  return names;
}

SkinnedRegion shaped(const RegionLayout& region) {
  const ModelLayout model{region};
  return model.skinned(0, model.minimize_energy(SurfaceStiffness::isotropic(0, 1)));
}

}  // namespace

TEST_CASE("an inner curve ends where a hole begins and continues behind it",
          "[skinning][layout][holes]") {
  auto lines = sheet();
  lines.push_back(circle("hole", {2, 1, 0}, 0.5));
  SkinOptions options = coarse();
  options.domain = GENERATE(Domain::Polygon, Domain::Projected);
  const RegionLayout layout("sheet", lines, options);
  CHECK(inner_names(layout) == std::vector<std::string>{"middle.1", "middle.2"});
  for (const EmbeddedLine& e : layout.embedded()) {
    if (e.line.role != Role::Inner) continue;
    const Vec3 a = e.fitted.evaluate(e.fitted.start()), b = e.fitted.evaluate(e.fitted.end());
    CHECK(std::abs(std::abs(b.x() - a.x()) - 1.5) < 1e-4);
  }
}

TEST_CASE("a curve that ends in a hole keeps its name, one that touches it stays whole",
          "[skinning][layout][holes]") {
  auto lines = sheet();
  lines[1] = line("middle", Role::Inner, {{0, 1, 0}, {2, 1, 0}});
  lines.push_back(circle("hole", {2, 1, 0}, 0.5));
  CHECK(inner_names({"sheet", lines, coarse()}) == std::vector<std::string>{"middle"});
  lines[1] = line("middle", Role::Inner, {{0, 1, 0}, {4, 1, 0}});
  lines[2] = circle("hole", {2, 1.6, 0}, 0.3);
  CHECK(inner_names({"sheet", lines, coarse()}) == std::vector<std::string>{"middle"});
}

TEST_CASE("a curve through two holes has three pieces", "[skinning][layout][holes]") {
  auto lines = sheet();
  lines.push_back(circle("one", {1, 1, 0}, 0.3));
  lines.push_back(circle("two", {3, 1.1, 0}, 0.3));
  CHECK(inner_names({"sheet", lines, coarse()}) ==
        std::vector<std::string>{"middle.1", "middle.2", "middle.3"});
}

TEST_CASE("curves that miss a hole's boundary are named with position and distance",
          "[skinning][layout][holes]") {
  auto lines = sheet();
  lines.push_back(circle("hole", {2, 1, 0.02}, 0.5));
  const auto make = [&] { RegionLayout("sheet", lines, coarse()); };
  CHECK_THAT(batten_test::error_message(make),
             Catch::Contains("inner curve 'middle' passes curve 'hole' of a hole at a distance of "
                             "0.02 near (1.5, 1, 0)"));
  lines[1] = line("middle", Role::Inner, {{1.8, 1, 0}, {2.2, 1, 0}});
  CHECK_THAT(batten_test::error_message(make),
             Catch::Contains("'middle' lies completely in a hole"));
}

TEST_CASE("a hole that does not hold leaves the shape as it is without it",
          "[skinning][layout][holes]") {
  // An arched roof: two arcs over straight sides, with a hole drawn in a plane below it.
  std::vector<CharacterLine> lines = {{"front", arc_through({0, 0, 0}, {1, 0, 0.4}, {2, 0, 0})},
                                      {"right", arc_through({2, 0, 0}, {2, 1.5, 0.3}, {2, 3, 0})},
                                      {"back", arc_through({2, 3, 0}, {1, 3, 0.4}, {0, 3, 0})},
                                      {"left", arc_through({0, 3, 0}, {0, 1.5, 0.3}, {0, 0, 0})}};
  SkinOptions options = coarse();
  options.domain = GENERATE(Domain::Polygon, Domain::Projected, Domain::Developable);
  const SkinnedRegion whole = shaped({"roof", lines, options});
  lines.push_back(circle("hole", {1, 1.4, 0.1}, 0.15));
  const SkinnedRegion held = shaped({"roof", lines, options});
  lines.back().constrains_surface = false;
  const SkinnedRegion free = shaped({"roof", lines, options});
  const EmbeddedLine* rim = nullptr;
  for (const EmbeddedLine& e : free.embedded)
    if (e.line.name == "hole") rim = &e;
  REQUIRE(rim);
  CHECK(rim->points.empty());
  CHECK(rim->fitted.segment_count() >= 4);
  double from_whole = 0;
  for (int i = 0; i < 64; ++i) {
    const Vec3 p = rim->fitted.evaluate(rim->fitted.start() +
                                        (rim->fitted.end() - rim->fitted.start()) * i / 64);
    from_whole = std::max(from_whole, whole.surface.closest_point(p).distance);
  }
  // Without the stiffness of the removed part, the rest bends slightly differently, far less than
  // with a constrained hole.
  CHECK(from_whole < 0.02);
  CHECK(measure(free).max_line_deviation < 1e-3);
  CHECK(measure(free).min_jacobian_ratio > 0.3);
  double pulled = 0;
  for (const EmbeddedLine& e : held.embedded)
    if (e.line.name == "hole")
      pulled = whole.surface.closest_point(e.fitted.evaluate(e.fitted.start())).distance;
  CHECK(pulled > 0.1);
}
