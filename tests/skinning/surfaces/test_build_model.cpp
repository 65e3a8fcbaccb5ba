// SPDX-License-Identifier: MPL-2.0
// From curves to a model in one call, and back to its curves.
#include "batten/skinning/surfaces/build_model.h"

#include <cmath>
#include <numbers>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/skinning/surfaces/section_region.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sample_networks.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

CharacterLine circle(const std::string& name, double radius, double z) {
  const CurvePlane plane = curve_plane({0, 0, z}, Vec3::UnitZ(), Vec3::UnitX());
  return {name, ellipse_arc(plane, radius, radius, 0, 2 * std::numbers::pi)};
}

}  // namespace

TEST_CASE("the edges of a box give a network of six faces", "[skinning][surfaces]") {
  ModelBuildOptions options;
  options.model.skin.edge_length = 0.5;
  const BuiltModel made = build_model(box_lines(Vec3::Zero(), {1, 1, 1}), options);
  REQUIRE(made.network);
  CHECK(made.found->regions.size() == 6);
  CHECK(made.region_names().size() == 6);
  CHECK(made.sections.empty());
  CHECK(made.model.shells.front().volume == Approx(1).epsilon(1e-8));
  CHECK(made.fit_tolerance == Approx(1e-4 * std::sqrt(3.0)));
  options.tolerance = [](double size) { return 1e-3 * size; };
  CHECK(build_model(box_lines(Vec3::Zero(), {1, 1, 1}), options).fit_tolerance ==
        Approx(1e-3 * std::sqrt(3.0)));
}

TEST_CASE("a small hole far from the middle of a plate leaves no sheared elements",
          "[skinning][surfaces]") {
  // An annulus between both circles would have elements that are nearly inverted.
  CharacterLine hole = circle("hole", 0.08, 0);
  hole.curve = ellipse_arc(curve_plane({0.85, 0, 0}, Vec3::UnitZ(), Vec3::UnitX()), 0.08, 0.08, 0,
                           2 * std::numbers::pi);
  const BuiltModel made = build_model({circle("rim", 1, 0), hole}, {});
  REQUIRE(made.model.skinned().size() == 1);
  CHECK(made.model.regions[0].warnings.empty());
  CHECK(made.model.regions[0].plan.loops.size() == 2);
  CHECK(made.model.regions[0].quality.min_jacobian_ratio > 0.5);
  CHECK(made.model.area == Approx(std::numbers::pi * (1 - 0.0064)).epsilon(1e-4));
}

TEST_CASE("a single face gets the name of the model, and can be requested with its layout",
          "[skinning][surfaces]") {
  ModelBuildOptions options;
  options.model.name = "door";
  const BuiltModel found = build_model(polygon_lines({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), options);
  REQUIRE(found.network);
  CHECK(found.region_names() == std::vector<std::string>{"door"});
  options.single_face = true;
  const BuiltModel requested =
      build_model(polygon_lines({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), options);
  CHECK_FALSE(requested.network);
  CHECK(requested.region_names() == std::vector<std::string>{"door"});
  CHECK(requested.model.dofs.rows() == 0);
}

TEST_CASE("inner curves make the outlines a single face", "[skinning][surfaces]") {
  const BuiltModel made = build_model(patch_with_inner_line(), {});
  CHECK_FALSE(made.network);
  CHECK(made.model.layout->region_count() == 1);
  CHECK(made.model.layout->has_line("rib"));
}

TEST_CASE("the normals of a single face do not depend on the direction of its curves",
          "[skinning][surfaces]") {
  ModelBuildOptions options;
  options.single_face = true;
  std::vector<CharacterLine> lines = curved_polygon(5, 0.2, 0);
  for (const bool backwards : {false, true}) {
    if (backwards) {
      std::reverse(lines.begin(), lines.end());
      for (CharacterLine& line : lines) line.curve = reversed(line.curve);
    }
    const BuiltModel made = build_model(lines, options);
    const ModelLayout& layout = *made.model.layout;
    const SkinnedRegion face = layout.skinned(0, layout.minimize_energy(options.model.material));
    CHECK(normal_side(side_integrals({&face}), false).agrees);
  }
}

TEST_CASE("three circles in a row are the sections of a loft", "[skinning][surfaces]") {
  const std::vector<CharacterLine> circles = {circle("low", 1, 0), circle("high", 1.2, 4),
                                              circle("middle", 1.5, 2)};
  const BuiltModel made = build_model(circles, {});
  CHECK_FALSE(made.network);
  const std::vector<std::string> up = {"low", "middle", "high"}, down(up.rbegin(), up.rend());
  CHECK((made.sections == up || made.sections == down));
}

TEST_CASE("curves without a closed loop are rejected with their gaps", "[skinning][surfaces]") {
  ModelBuildOptions options;
  options.unit = "mm";
  options.network_where = "scene.toml:2:1: ";
  const std::string text = error_message([&] {
    build_model({straight("a", {0, 0, 0}, {1, 0, 0})}, options);
  });
  CHECK_THAT(text, Contains("scene.toml:2:1: found no closed loop of curves"));
  CHECK_THAT(text, Contains(" mm)"));
}

TEST_CASE("the curves of a model merge the edges of the network that continue each other",
          "[skinning][surfaces]") {
  ModelBuildOptions options;
  options.model.skin.edge_length = 0.3;
  const std::vector<CharacterLine> lines = sphere_lines();
  const BuiltModel made = build_model(lines, options);
  const std::vector<CubicSpline> splines = model_curves(made.model, &*made.network);
  REQUIRE(splines.size() == 3);
  for (const CubicSpline& spline : splines) {
    CHECK(spline.closed);
    for (const Vec3& pole : spline.poles) CHECK(pole.norm() == Approx(1).margin(0.05));
  }
  // The edges of a box are separate curves, with their names.
  const BuiltModel box = build_model(box_lines(Vec3::Zero(), {1, 1, 1}), options);
  CHECK(model_curves(box.model, &*box.network).size() == 12);
  CHECK(model_curves(box.model, nullptr).size() == 12);
}

TEST_CASE("sections in a wrong order are rejected with the rails that they cause",
          "[skinning][surfaces]") {
  const auto message = [](const std::vector<double>& heights) {
    ModelBuildOptions options;
    options.single_face = true;
    std::vector<CharacterLine> lines;
    for (const double y : heights) {
      options.sections.push_back("section " + std::to_string(lines.size()));
      lines.push_back(straight(options.sections.back(), {0, y, 0}, {4, y, 0}));
    }
    return error_message([&] { build_model(lines, options); });
  };
  CHECK(message({0, 1, 2, 3}).empty());
  const std::string hint = "rails run through the ends of the sections in their order";
  CHECK_THAT(message({0, 2, 1, 3}), Contains("curve 'rail 1' intersects itself") && Contains(hint));
  // A part of a rail between two of its corners.
  CHECK_THAT(message({0, 1, 3, 2}), Contains("'rail 1.1' intersect") && Contains(hint));
  const std::string coincident = message({0, 1, 1, 2});
  CHECK_THAT(coincident, Contains("shares an end with the section before it"));
  CHECK_THAT(coincident, !Contains(hint));
}

TEST_CASE("the rails of sections and their parts are recognised by their names",
          "[skinning][surfaces]") {
  for (const char* rail : {"rail 1", "rail 2", "rail 1.1", "rail 2.12"}) CHECK(is_rail(rail));
  for (const char* other : {"", "rail", "rail 3", "rail 12", "guard rail 1"})
    CHECK_FALSE(is_rail(other));
}
