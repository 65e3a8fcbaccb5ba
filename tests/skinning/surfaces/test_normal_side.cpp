// SPDX-License-Identifier: MPL-2.0
// The side of normals, independent of the order and direction of the curves and of the proportions.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/normal_side.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_networks.h"

using namespace batten;
using namespace batten_test;
using Rule = NormalSide::Rule;

namespace {

using std::numbers::pi;
using Lines = std::vector<CharacterLine>;

// centre + a cos t + b sin t, t from `from` to `to`.
CharacterLine arc(const std::string& name, const Vec3& centre, const Vec3& a, const Vec3& b,
                  double from, double to) {
  return {name, curve_from_formula(from, to, [=](double t, int order) -> Vec3 {
            if (order == 0) return centre + a * std::cos(t) + b * std::sin(t);
            if (order == 1) return -a * std::sin(t) + b * std::cos(t);
            return -a * std::cos(t) - b * std::sin(t);
          })};
}

const Vec3 X = Vec3::UnitX(), Y = Vec3::UnitY(), Z = Vec3::UnitZ();

Lines tube(double length) {
  return {arc("bottom", Vec3::Zero(), X, Y, 0, 2 * pi), arc("top", length * Z, X, Y, 0, 2 * pi)};
}
Lines half_cylinder(const Vec3& up) {
  return {arc("front", Vec3::Zero(), X, up, 0, pi), arc("back", 5 * Y, X, up, 0, pi),
          straight("left", -X, 5 * Y - X), straight("right", X, 5 * Y + X)};
}
Lines dome(const Vec3& up) {
  Lines lines{arc("base", Vec3::Zero(), X, Y, 0, 2 * pi)};
  for (int k = 0; k < 4; ++k) {
    const double a = k * pi / 2;
    lines.push_back(arc("m" + std::to_string(k), Vec3::Zero(), std::cos(a) * X + std::sin(a) * Y,
                        up, 0, pi / 2));
  }
  return lines;
}
Lines canopy(const Vec3& up) {
  return {arc("a", Vec3::Zero(), 2 * X, up, 0, pi), arc("b", 6 * Y, 2 * X, 1.5 * up, 0, pi),
          arc("l", 3 * Y - 2 * X, -3 * Y, up, 0, pi), arc("r", 3 * Y + 2 * X, -3 * Y, up, 0, pi)};
}
Lines quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {straight("1", a, b), straight("2", b, c), straight("3", c, d), straight("4", d, a)};
}

CharacterLine reversed(const CharacterLine& line) {
  const auto curve = line.curve;
  const double from = curve->breaks().front(), to = curve->breaks().back();
  return {line.name, curve_from_formula(from, to, [=](double t, int order) {
            return Vec3((order % 2 ? -1 : 1) * curve->evaluate(from + to - t, order));
          })};
}

SurfaceModel model_of(const Lines& lines, const RegionSearchOptions& regions = {}) {
  ModelOptions options;
  const CurveNetwork network(lines);
  options.skin.edge_length = network.size() / 12;
  return skin_network(network, find_regions(network, regions), options);
}

// The curves in the given, and in other orders and directions.
std::vector<Lines> drawn_otherwise(const Lines& lines) {
  std::vector<Lines> all{lines};
  std::mt19937 random(7);
  for (int k = 0; k < 3; ++k) {
    Lines other = lines;
    std::shuffle(other.begin(), other.end(), random);
    for (CharacterLine& line : other)
      if (random() % 2) line = reversed(line);
    all.push_back(other);
  }
  return all;
}

// Maximum and minimum of (x - middle) · n, over the normals at the centroids of the elements.
void check_normals(const SurfaceModel& model,
                   const std::function<double(const SurfaceJet&)>& value) {
  double least = 1e9;
  for (const SkinnedRegion* region : model.skinned())
    for (int t = 0; t < region->surface.mesh().triangle_count(); ++t)
      least = std::min(least, value(region->surface.jet({t})));
  CHECK(least > 0);
}

}  // namespace

TEST_CASE("a tube's normals point away from its axis, whatever its length",
          "[skinning][surfaces]") {
  for (const double length : {0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 20.0})
    for (const Lines& lines : drawn_otherwise(tube(length))) {
      INFO("length " << length);
      const SurfaceModel model = model_of(lines);
      REQUIRE(model.shells.size() == 1);
      CHECK(model.shells[0].normals.text() == "to the convex side");
      check_normals(model, [](const SurfaceJet& jet) {
        return jet.normal().dot(Vec3(jet.x.x(), jet.x.y(), 0));
      });
    }
}

TEST_CASE("half cylinders, domes and canopies show their outside, up or down, however drawn",
          "[skinning][surfaces]") {
  for (const double sign : {1.0, -1.0}) {
    INFO("up " << sign);
    for (const auto& shape :
         {half_cylinder(sign * Z), dome(0.6 * sign * Z), canopy(0.5 * sign * Z)})
      for (const Lines& lines : drawn_otherwise(shape)) {
        const SurfaceModel model = model_of(lines);
        REQUIRE(model.shells.size() == 1);
        CHECK(model.shells[0].normals.rule == Rule::Curvature);
        CHECK(model.shells[0].normals.agrees);
        CHECK(sign * model.shells[0].normals.mean.z() > 0.5);
      }
  }
}

TEST_CASE("creases count: an open box points outwards", "[skinning][surfaces]") {
  RegionSearchOptions open;
  RegionSpec nothing;
  nothing.kind = RegionSpec::Kind::NoSurface;
  nothing.loops = {{"x3", "x4", "y2", "y4"}};
  open.specs = {nothing};
  for (const Lines& lines : drawn_otherwise(box_lines(Vec3::Zero(), Vec3(1, 1, 0.2)))) {
    const SurfaceModel model = model_of(lines, open);
    REQUIRE(model.regions.size() == 5);
    CHECK(model.shells[0].normals.rule == Rule::Curvature);
    check_normals(
        model, [](const SurfaceJet& jet) { return jet.normal().dot(jet.x - Vec3(0.5, 0.5, 0.1)); });
  }
}

TEST_CASE("where curvature decides nothing, normals point up, along x or along y",
          "[skinning][surfaces]") {
  const std::vector<std::pair<Lines, Vec3>> shapes{
      {quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}), Z},
      {quad({0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}), X},
      {quad({0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}), Y},
      {quad({1, 0, 0}, {0, 1, 1}, {-1, 0, 0}, {0, -1, 1}), Z}};  // a hyperbolic paraboloid
  for (const auto& [shape, direction] : shapes)
    for (const Lines& lines : drawn_otherwise(shape)) {
      const SurfaceModel model = model_of(lines);
      REQUIRE(model.shells.size() == 1);
      CHECK(model.shells[0].normals.rule == Rule::Axis);
      CHECK(model.shells[0].normals.mean.dot(direction) > 0.5);
    }
}

TEST_CASE("the integrals of finished surfaces: M = πL of a tube, 4πR of a sphere",
          "[skinning][surfaces]") {
  const SurfaceModel can = model_of(tube(2));
  const SideIntegrals of_tube = side_integrals(can.skinned());
  CHECK(of_tube.area == Approx(4 * pi).epsilon(0.02));
  CHECK(of_tube.curvature == Approx(2 * pi).epsilon(0.02));
  CHECK(of_tube.area_vector.norm() < 1e-9);

  const SideIntegrals ball = side_integrals(model_of(sphere_lines()).skinned());
  CHECK(ball.curvature == Approx(4 * pi).epsilon(0.03));
  CHECK(ball.area_vector.norm() < 1e-9);
  CHECK(ball.central_moments().trace() == Approx(4 * pi).epsilon(0.05));

  // An open box has a quarter turn on each of eight edges: ½ · ½π · length.
  RegionSearchOptions open;
  RegionSpec nothing;
  nothing.kind = RegionSpec::Kind::NoSurface;
  nothing.loops = {{"x3", "x4", "y2", "y4"}};
  open.specs = {nothing};
  const auto box = model_of(box_lines(Vec3::Zero(), Vec3(1, 1, 1)), open);
  CHECK(side_integrals(box.skinned()).curvature == Approx(0.25 * pi * 8).epsilon(1e-6));
}

TEST_CASE("the rule on integrals: its order, its deadband, and both signs",
          "[skinning][surfaces]") {
  SideIntegrals s;
  s.area = 4;
  CHECK(normal_side(s, false).rule == Rule::None);
  CHECK(normal_side(s, false).agrees);
  s.moments(0, 0) = -1;
  CHECK(normal_side(s, false).rule == Rule::Moment);
  CHECK_FALSE(normal_side(s, false).agrees);
  CHECK(normal_side(s, true).text() == "inwards");
  s.area_vector = Vec3(4, -3, 0.1);
  CHECK(normal_side(s, false).text() == "along (0.8, -0.6, 0.02)");
  s.area_vector.z() = -0.3;
  CHECK_FALSE(normal_side(s, false).agrees);
  s.curvature = 0.019;  // of √A = 2 at most 0.01
  CHECK(normal_side(s, false).rule == Rule::Axis);
  s.curvature = 0.021;
  CHECK(normal_side(s, false).text() == "to the convex side");
  s.curvature = -0.021;
  CHECK(normal_side(s, false).text() == "to the concave side");
}
