// SPDX-License-Identifier: MPL-2.0
// Half models: mirror images of curves, joins and faces.
#include "batten/skinning/surfaces/mirror_images.h"

#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sample_networks.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A curve in the plane y = 0, one that ends in it, and one beside it.
std::vector<CharacterLine> half() {
  return {straight("keel", {0, 0, 0}, {2, 0, 0}), straight("frame", {0, 0, 0}, {0, 1, 0}),
          straight("rail", {0, 1, 0}, {2, 1, 0})};
}

const SymmetryPlane kPlane{Vec3::Zero(), Vec3::UnitY()};

}  // namespace

TEST_CASE("curves in the plane of symmetry are not mirrored, the others are",
          "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = half();
  add_mirror_images(kPlane, lines);
  REQUIRE(lines.size() == 5);
  CHECK(lines[3].name == "mirrored frame");
  CHECK(lines[4].name == "mirrored rail");
  for (const double t : {0.0, 0.3, 1.0}) {
    const double u =
        lines[2].curve->start() + t * (lines[2].curve->end() - lines[2].curve->start());
    const Vec3 p = lines[2].curve->evaluate(u), q = lines[4].curve->evaluate(u);
    CHECK(q == Vec3(p.x(), -p.y(), p.z()));
  }
  // The frame continues in its mirror image.
  CHECK(lines[1].curve->evaluate(lines[1].curve->start()) ==
        lines[3].curve->evaluate(lines[3].curve->start()));
}

TEST_CASE("any plane is a plane of symmetry, and a curve that crosses it is rejected",
          "[skinning][surfaces]") {
  const Vec3 normal = Vec3(1, 2, -1).normalized(), point(3, -1, 2), side = normal.unitOrthogonal();
  const auto at = [&](double along, double height) -> Vec3 {
    return point + along * side + height * normal;
  };
  std::vector<CharacterLine> lines = {straight("a", at(0, 0), at(0, 1)),
                                      straight("b", at(0, 0), at(1, 0))};
  add_mirror_images({point, 5 * normal}, lines);
  REQUIRE(lines.size() == 3);
  CHECK((lines[2].curve->evaluate(lines[2].curve->end()) - at(0, -1)).norm() < 1e-12);
  lines = {straight("across", at(0, -1), at(0, 1))};
  CHECK_THAT(error_message([&] {
               add_mirror_images({point, normal}, lines);
             }),
             Contains("'across', which crosses the plane of symmetry"));
  CHECK_FALSE(error_message([&] { add_mirror_images({point, Vec3::Zero()}, lines); }).empty());
}

TEST_CASE("a tolerance decides which curves lie in the plane", "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = {straight("low", {0, 0.05, 0}, {1, 0.05, 0}),
                                      straight("high", {0, 1, 0}, {1, 1, 0})};
  std::vector<CharacterLine> copy = lines;
  add_mirror_images(kPlane, copy);
  CHECK(copy.size() == 4);
  add_mirror_images({Vec3::Zero(), Vec3::UnitY(), 0.1}, lines);
  CHECK(lines.size() == 3);
}

TEST_CASE("joins are mirrored if their curves are, and the given ones come last",
          "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = half();
  add_mirror_images(kPlane, lines);
  const std::vector<JoinSpec> joins = {{"keel", JoinSpec::Kind::Smooth, "1: "},
                                       {"rail.2", JoinSpec::Kind::Crease, "2: "}};
  const std::vector<JoinSpec> all = with_mirror_images(joins, lines);
  REQUIRE(all.size() == 3);
  CHECK(all[0].line == "mirrored rail.2");
  CHECK(all[0].kind == JoinSpec::Kind::Crease);
  CHECK(all[0].where == "2: ");
  CHECK(all[1].line == "keel");
  CHECK(all[2].line == "rail.2");
}

TEST_CASE("faces are mirrored unless they are whole or their image is specified",
          "[skinning][surfaces]") {
  std::vector<CharacterLine> lines = half();
  add_mirror_images(kPlane, lines);
  RegionSpec side, whole, image;
  side.name = "side";
  side.loops = {{"keel", "frame", "rail"}};
  whole.loops = {{"rail", "mirrored rail"}};
  std::vector<RegionSpec> all = with_mirror_images(std::vector{side, whole}, lines);
  REQUIRE(all.size() == 3);
  CHECK(all[2].name == "mirrored side");
  CHECK(all[2].loops ==
        std::vector<std::vector<std::string>>{{"keel", "mirrored frame", "mirrored rail"}});
  image.loops = {{"mirrored rail", "keel", "mirrored frame"}};
  all = with_mirror_images(std::vector{side, image}, lines);
  CHECK(all.size() == 2);
}
