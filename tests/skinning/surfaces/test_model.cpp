// SPDX-License-Identifier: MPL-2.0
// Models from networks: orientation, shared edges, shells, measures.
#include <cmath>
#include <map>
#include <numbers>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_networks.h"

using namespace batten;
using namespace batten_test;

namespace {

SurfaceModel model_of(const std::vector<CharacterLine>& lines, ModelOptions options = {},
                      const RegionSearchOptions& regions = {}) {
  const CurveNetwork network(lines);
  return skin_network(network, find_regions(network, regions), options);
}

}  // namespace

TEST_CASE("a cube: six creased faces of a closed shell, area 6 and volume 1, normals outwards",
          "[skinning][surfaces]") {
  ModelOptions options;
  options.skin.edge_length = 0.3;
  for (const Vec3& moved : {Vec3(0, 0, 0), Vec3(1e4, -2e4, 3e4)}) {
    const SurfaceModel model = model_of(box_lines(moved, Vec3(1, 1, 1)), options);
    REQUIRE(model.regions.size() == 6);
    REQUIRE(model.shells.size() == 1);
    CHECK(model.shells[0].closed);
    CHECK(model.shells[0].orientable);
    CHECK(model.shells[0].area == Approx(6).epsilon(1e-9));
    CHECK(model.shells[0].volume == Approx(1).epsilon(1e-8));
    CHECK(model.defects.empty());
    REQUIRE(model.joins.size() == 12);
    for (const ModelJoin& join : model.joins) {
      CHECK(join.kind == ModelJoin::Kind::Crease);
      CHECK(join.initial_deg == Approx(90));
      CHECK(join.max_deg == Approx(90));
    }
    const Vec3 middle = moved + Vec3(0.5, 0.5, 0.5);
    for (const SkinnedRegion* r : model.skinned()) {
      const SurfaceJet jet = r->surface.jet({0});
      CHECK(jet.normal().dot(jet.x - middle) > 0.4);
    }
  }
}

TEST_CASE("eight octants of a sphere become one smooth closed shell near it",
          "[skinning][surfaces]") {
  ModelOptions options;
  options.skin.edge_length = 0.2;
  const SurfaceModel model = model_of(sphere_lines(), options);
  REQUIRE(model.regions.size() == 8);
  REQUIRE(model.shells.size() == 1);
  CHECK(model.shells[0].closed);
  CHECK(model.defects.empty());
  CHECK(model.max_join_deg < 0.1);
  for (const ModelJoin& join : model.joins) {
    CHECK(join.kind == ModelJoin::Kind::Smooth);
    CHECK_FALSE(join.open[0]);
    CHECK_FALSE(join.open[1]);
  }
  // The great circles interpolate it; minimum bending energy stays close to it between them.
  CHECK(model.shells[0].volume == Approx(4 * std::numbers::pi / 3).epsilon(0.02));
  double worst = 0;
  for (const SkinnedRegion* r : model.skinned())
    for (int t = 0; t < r->surface.mesh().triangle_count(); ++t)
      worst = std::max(worst, std::abs(r->surface.position({t}).norm() - 1));
  CHECK(worst < 0.03);
}

TEST_CASE("the user's setting makes a crease of a smooth curve and names what cannot be smooth",
          "[skinning][surfaces]") {
  ModelOptions options;
  options.skin.edge_length = 0.3;
  options.rest = false;  // sweeps are the sphere: creases would be invisible
  options.joins = {{"xy", JoinSpec::Kind::Crease, "scene:1: "}};
  const SurfaceModel model = model_of(sphere_lines(), options);
  int creases = 0;
  for (const ModelJoin& join : model.joins)
    if (join.kind == ModelJoin::Kind::Crease) {
      ++creases;
      CHECK(join.requested);
      CHECK(join.max_deg > 1);
    }
  CHECK(creases == 4);

  options.joins = {{"no such line", JoinSpec::Kind::Smooth, "scene:7: "}};
  CHECK_THROWS_WITH(model_of(sphere_lines(), options), Catch::Matchers::StartsWith("scene:7: "));

  // A box corner has no tangent plane.
  options.joins = {{"z1", JoinSpec::Kind::Smooth, ""}};
  const SurfaceModel box = model_of(box_lines(Vec3::Zero(), Vec3(1, 1, 1)), options);
  for (const ModelJoin& join : box.joins)
    if (join.requested) {
      CHECK((join.kind == ModelJoin::Kind::Crease || (join.open[0] && join.open[1])));
      CHECK((!join.why.empty() || !box.warnings.empty()));
    }
}

TEST_CASE("faces share the vertices of their curves, positions bit for bit",
          "[skinning][surfaces]") {
  const SurfaceModel model = model_of(sphere_lines());
  std::map<std::string, std::vector<Vec3>> seen;
  int shared = 0;
  for (const SkinnedRegion* r : model.skinned())
    for (const EdgeAlignedLine& aligned_line : r->edge_aligned) {
      std::vector<Vec3> points;
      for (const int v : aligned_line.vertices)
        points.push_back(r->surface.dofs().row(r->surface.dof_map().vertex(v)));
      const auto [it, first] = seen.emplace(aligned_line.line.name, points);
      if (first) continue;
      ++shared;
      REQUIRE(it->second.size() == points.size());
      double apart = 0;
      for (size_t i = 0; i < points.size(); ++i)
        apart = std::max(apart, (it->second[i] - points[i]).norm());
      CHECK(apart < 1e-14);
    }
  CHECK(shared == 12);
}

TEST_CASE("a one-sided strip is skinned and found not orientable", "[skinning][surfaces]") {
  // Three quads around a Möbius strip.
  std::vector<CharacterLine> lines;
  const auto at = [](double turn, double side) {
    const double t = 2 * std::numbers::pi * turn, h = 0.5 * t, r = 2 + 0.5 * side * std::cos(h);
    return Vec3(r * std::cos(t), r * std::sin(t), 0.5 * side * std::sin(h));
  };
  for (int i = 0; i < 3; ++i) {
    lines.push_back(straight("rung " + std::to_string(i), at(i / 3.0, -1), at(i / 3.0, 1)));
    for (const int side : {-1, 1}) {
      std::vector<Vec3> points;
      for (int k = 0; k <= 12; ++k) points.push_back(at((i + k / 12.0) / 3, side));
      lines.push_back({"side " + std::to_string(i) + (side < 0 ? "a" : "b"),
                       curve_through_points("side", points)});
    }
  }
  const SurfaceModel model = model_of(lines);
  REQUIRE(model.regions.size() == 3);
  REQUIRE(model.shells.size() == 1);
  CHECK_FALSE(model.shells[0].orientable);
  CHECK_FALSE(model.shells[0].closed);
  CHECK(model.shells[0].volume == 0);
  for (const ModelRegion& r : model.regions) CHECK(r.skinned.has_value());
}

TEST_CASE("boundaries and holes run around faces: volumes of a can, a torus, a box with a pocket",
          "[skinning][surfaces]") {
  const double pi = std::numbers::pi;
  const auto circle = [&](const std::string& name, const Vec3& centre, const Vec3& a,
                          const Vec3& b) {
    return CharacterLine{name, curve_from_formula(0, 2 * pi, [=](double t, int order) -> Vec3 {
                           if (order == 0) return centre + a * std::cos(t) + b * std::sin(t);
                           if (order == 1) return -a * std::sin(t) + b * std::cos(t);
                           return -a * std::cos(t) - b * std::sin(t);
                         })};
  };
  const auto word = [](std::vector<std::vector<std::string>> loops, bool annulus = false) {
    RegionSpec w;
    w.loops = std::move(loops);
    w.annulus = annulus;
    return w;
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  ModelOptions options;
  options.crease_angle_deg = -1;
  for (const double sense : {1.0, -1.0}) {
    RegionSearchOptions regions;
    regions.specs = {word({{"low"}, {"high"}}, true), word({{"low"}}), word({{"high"}})};
    const SurfaceModel can = model_of(
        {circle("low", Vec3::Zero(), x, y), circle("high", 2 * z, x, sense * y)}, options, regions);
    REQUIRE(can.shells.size() == 1);
    CHECK(can.shells[0].closed);
    // Minimum bending energy without stretching narrows the waist.
    CHECK(can.shells[0].volume == Approx(2 * pi).epsilon(0.2));

    std::vector<CharacterLine> lines;
    RegionSearchOptions rings;
    for (int i = 0; i < 4; ++i) {
      const Vec3 out = std::cos(i * pi / 2) * x + std::sin(i * pi / 2) * y;
      lines.push_back(
          circle("c" + std::to_string(i), 2 * out, 0.7 * out, (i % 2 ? sense : 1) * 0.7 * z));
      rings.specs.push_back(
          word({{"c" + std::to_string(i)}, {"c" + std::to_string((i + 1) % 4)}}, true));
    }
    const SurfaceModel torus = model_of(lines, options, rings);
    REQUIRE(torus.shells.size() == 1);
    CHECK(torus.shells[0].closed);
    CHECK(torus.shells[0].orientable);
    CHECK(torus.shells[0].volume > 5);

    auto box = box_lines(Vec3::Zero(), Vec3(3, 3, 3));
    RegionSearchOptions pocket;
    for (CharacterLine line : box_lines(Vec3(1, 1, 2), Vec3(1, 1, 1))) {
      line.name = "p" + line.name;
      if (sense < 0 && line.name == "px3")
        line.curve = curve_through_points("px3", {Vec3(2, 1, 3), Vec3(1, 1, 3)});
      box.push_back(line);
    }
    pocket.specs = {word({{"x3", "x4", "y2", "y4"}, {"px3", "px4", "py2", "py4"}})};
    RegionSpec open;
    open.kind = RegionSpec::Kind::NoSurface;
    open.loops = {{"px3", "px4", "py2", "py4"}};
    pocket.specs.push_back(open);
    const SurfaceModel model = model_of(box, options, pocket);
    CHECK(model.shells.size() == 1);
    CHECK(model.shells[0].volume == Approx(26).epsilon(1e-6));
  }
}

TEST_CASE("a tube with a cut along it is an annulus with a curve on it", "[skinning][surfaces]") {
  const auto circle = [](const std::string& name, double z) {
    return CharacterLine{
        name, curve_from_formula(0, 2 * std::numbers::pi, [z](double t, int order) -> Vec3 {
          const Vec3 p(std::cos(t), std::sin(t), 0);
          if (order == 0) return p + Vec3(0, 0, z);
          if (order == 1) return {-p.y(), p.x(), 0};
          return -p;
        })};
  };
  const SurfaceModel model = model_of(
      {circle("low", 0), circle("high", 1), straight("cut", Vec3(0, 1, 0), Vec3(0, 1, 1))});
  REQUIRE(model.regions.size() == 1);
  CHECK(model.regions[0].plan.annulus);
  INFO(model.regions[0].rejection_reason);
  REQUIRE(model.regions[0].skinned.has_value());
  CHECK(model.regions[0].skinned->embedded.size() == 1);
  CHECK(model.area == Approx(2 * std::numbers::pi).epsilon(0.05));
}

TEST_CASE("a model scales: the same network in mm and in m is the same shape",
          "[skinning][surfaces]") {
  const auto lines = sphere_lines();
  const auto scaled = sphere_lines(1000);
  ModelOptions options;
  options.skin.edge_length = 0.3;
  const SurfaceModel one = model_of(lines, options);
  options.skin.edge_length = 300;
  const SurfaceModel thousand = model_of(scaled, options);
  REQUIRE(one.dofs.rows() == thousand.dofs.rows());
  double apart = 0;
  for (size_t r = 0; r < one.regions.size(); ++r)
    apart = std::max(apart, (one.regions[r].skinned->surface.dofs() -
                             thousand.regions[r].skinned->surface.dofs() / 1000)
                                .cwiseAbs()
                                .maxCoeff());
  CHECK(apart < 1e-9);
}
