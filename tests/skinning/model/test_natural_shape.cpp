// Shapes that boundary lines mean: cylinders, cones, spheres and tori come from arcs and straight
// lines without a word, and stay what they are in a model.
#include <cmath>
#include <numbers>
#include <set>

#include "batten/fairing/curve_shapes.h"
#include "batten/skinning/model/natural_shape.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/catch.h"
#include "batten/tests/skinning/network/networks.h"

using namespace batten;
using namespace batten_test;

namespace {

using std::numbers::pi;
using Kind = MeasuredShape::Kind;
using Lines = std::vector<CharacterLine>;

CurvePlane level(double z) { return {Vec3(0, 0, z)}; }

CharacterLine arc(const std::string& name, double z, double radius, double from, double to) {
  return {name, ellipse_arc(level(z), radius, radius, from, to)};
}

// A quarter between two levels with straight sides.
Lines quarter(double low, double high, double height = 3) {
  const auto at = [](double r, double turn, double z) {
    return Vec3(r * std::cos(turn), r * std::sin(turn), z);
  };
  return {arc("low", 0, low, 0, pi / 2), arc("high", height, high, 0, pi / 2),
          straight("first", at(low, 0, 0), at(high, 0, height)),
          straight("last", at(low, pi / 2, 0), at(high, pi / 2, height))};
}

SurfaceModel model_of(const Lines& lines, const RegionOptions& regions = {},
                      ModelOptions options = {}) {
  const CharacterLineNetwork network(lines);
  return skin_network(network, find_regions(network, regions), options);
}

// Largest | distance from the z axis - radius | over the surface.
template <class Radius>
double off_axis(const SkinnedRegion& region, const Radius& radius) {
  double worst = 0;
  const Surface& surface = region.surface;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    for (const Vec3& L : {Vec3(1, 1, 1), Vec3(4, 1, 1), Vec3(1, 4, 1), Vec3(1, 1, 4)}) {
      const Vec3 x = surface.position({t, L / L.sum()});
      worst = std::max(worst, std::abs(std::hypot(x.x(), x.y()) - radius(x.z())));
    }
  return worst;
}

}  // namespace

TEST_CASE("two equal arcs and two straight lines are a piece of a cylinder") {
  const SurfaceModel model = model_of(quarter(2, 2));
  REQUIRE(model.skinned().size() == 1);
  CHECK(model.regions[0].shape.kind == Kind::Cylinder);
  CHECK(model.regions[0].shape.radius == Approx(2).epsilon(1e-3));
  CHECK(off_axis(*model.skinned()[0], [](double) { return 2; }) < 1e-3);
  // What bends least sags: the law would not hold without the shape that the lines mean.
  ModelOptions bending;
  bending.natural = false;
  const SurfaceModel bent = model_of(quarter(2, 2), {}, bending);
  CHECK(bent.regions[0].shape.kind == Kind::Free);
  CHECK(off_axis(*bent.skinned()[0], [](double) { return 2; }) > 0.02);
}

TEST_CASE("arcs of two radii about one axis are a piece of a cone") {
  const SurfaceModel model = model_of(quarter(2, 1));
  REQUIRE(model.skinned().size() == 1);
  CHECK(model.regions[0].shape.kind == Kind::Cone);
  CHECK(off_axis(*model.skinned()[0], [](double z) { return 2 - z / 3; }) < 1e-3);
}

TEST_CASE("a can between two circles is a cylinder of its volume") {
  Lines lines = {arc("low", 0, 20, 0, 2 * pi), arc("high", 40, 20, 0, 2 * pi)};
  RegionOptions options;
  for (const char* name : {"low", "high"}) {
    RegionWord lid;
    lid.loops = {{name}};
    options.words.push_back(lid);
  }
  RegionWord wall;
  wall.loops = {{"low"}, {"high"}};
  wall.ring = true;
  options.words.push_back(wall);
  const SurfaceModel model = model_of(lines, options);
  REQUIRE(model.shells.size() == 1);
  CHECK(model.shells[0].volume == Approx(pi * 400 * 40).epsilon(1e-3));
  std::multiset<Kind> kinds;
  for (const ModelRegion& region : model.regions) kinds.insert(region.shape.kind);
  CHECK(kinds == std::multiset<Kind>{Kind::Plane, Kind::Plane, Kind::Cylinder});
}

TEST_CASE("arcs about an axis and equal arcs through it are pieces of a torus, smooth all over") {
  Lines lines;
  constexpr double far = 100, tube = 30;
  for (int k = 0; k < 4; ++k) {  // around the tube: outside, above, inside, below
    const double a = k * pi / 2;
    const CurvePlane plane = level(tube * std::sin(a));
    const double radius = far + tube * std::cos(a);
    lines.push_back({"rail" + std::to_string(k), ellipse_arc(plane, radius, radius, 0, 2 * pi)});
    const Vec3 out(std::cos(a), std::sin(a), 0);
    lines.push_back({"ring" + std::to_string(k),
                     ellipse_arc({far * out, out, Vec3::UnitZ()}, tube, tube, 0, 2 * pi)});
  }
  const SurfaceModel model = model_of(lines);
  REQUIRE(model.skinned().size() == 16);
  for (const ModelRegion& region : model.regions) CHECK(region.shape.kind == Kind::Torus);
  for (const ModelJoin& join : model.joins) CHECK(join.kind == ModelJoin::Kind::Smooth);
  CHECK(model.max_join_deg < 0.1);
  REQUIRE(model.shells.size() == 1);
  CHECK(model.shells[0].closed);
  CHECK(model.shells[0].volume == Approx(2 * pi * pi * far * tube * tube).epsilon(2e-3));
}

TEST_CASE("flat walls and round fillets go on smoothly and stay flat and round") {
  const SurfaceModel model = model_of({
      arc("round low", 0, 1, 0, pi / 2),
      arc("round high", 4, 1, 0, pi / 2),
      straight("a low", {1, 0, 0}, {1, -5, 0}),
      straight("a high", {1, 0, 4}, {1, -5, 4}),
      straight("b low", {0, 1, 0}, {-5, 1, 0}),
      straight("b high", {0, 1, 4}, {-5, 1, 4}),
      straight("seam a", {1, 0, 0}, {1, 0, 4}),
      straight("seam b", {0, 1, 0}, {0, 1, 4}),
      straight("end a", {1, -5, 0}, {1, -5, 4}),
      straight("end b", {-5, 1, 0}, {-5, 1, 4}),
  });
  REQUIRE(model.skinned().size() == 3);
  std::multiset<Kind> kinds;
  for (const ModelRegion& region : model.regions) kinds.insert(region.shape.kind);
  CHECK(kinds == std::multiset<Kind>{Kind::Plane, Kind::Plane, Kind::Cylinder});
  int smooth = 0;
  for (const ModelJoin& join : model.joins) smooth += join.kind == ModelJoin::Kind::Smooth;
  CHECK(smooth == 2);
  CHECK(model.area == Approx(2 * 20 + 2 * pi).epsilon(1e-4));
}

TEST_CASE("lines that mean nothing of the kind are left to bend") {
  Lines lines = quarter(2, 2);
  SECTION("a side that is bent") {
    lines[3] = {"last",
                curve_through_points("last", {Vec3(0, 2, 0), Vec3(-0.3, 2.2, 1.5), Vec3(0, 2, 3)})};
  }
  SECTION("a line inside") {
    const double h = std::sqrt(0.5);
    lines.push_back(
        {"rib", curve_through_points("rib", {Vec3(2 * h, 2 * h, 0), Vec3(2.1 * h, 2.1 * h, 1.5)})});
  }
  SECTION("an arc that is tilted") {
    lines[1] = {"high", arc_through(Vec3(2, 0, 3), Vec3(1.5, 1.5, 3.5), Vec3(0, 2, 3))};
  }
  const SurfaceModel model = model_of(lines);
  REQUIRE_FALSE(model.skinned().empty());
  for (const ModelRegion& region : model.regions) CHECK(region.shape.kind == Kind::Free);
  CHECK(natural_dofs(*model.layout).rows() == 0);
}
