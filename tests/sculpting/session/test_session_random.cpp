// SPDX-License-Identifier: MPL-2.0
// Random operations on the door.
#include "batten/tests/support/random_sculptor.h"

using namespace batten_test;

namespace {

SculptorStage door() {
  SculptorStage stage;
  stage.layout = [] { return ModelLayout(door_layout(120, 4)); };
  stage.up = Vec3::UnitY();
  stage.step = 5;
  stage.finger = {-100, 60, 0};
  stage.stiff = {Area::NearLine{"rib", 80}};
  stage.whole = {"hinge hollow"};
  stage.fading = {"rib", "window line"};
  stage.edited = "rib";
  stage.inner = [](const SculptingSession& session, Random& random) {
    const Surface shape = shape_of(session);
    const Vec3 from(-150 + 60 * random(), 60, 20 + 20 * random());
    std::vector<Vec3> points;
    for (int i = 0; i <= 6; ++i)
      points.push_back(shape.position(shape.closest_point(from + Vec3(25 * i, 0, 2 * i)).where));
    return points;
  };
  return stage;
}

}  // namespace

TEST_CASE("three hundred operations at random on the door", "[sculpting][session]") {
  sculpt_at_random(door(), 300, 1);
}

TEST_CASE("ten thousand operations at random on the door", "[sculpting][session][.long]") {
  sculpt_at_random(door(), 10000, 7);
}
