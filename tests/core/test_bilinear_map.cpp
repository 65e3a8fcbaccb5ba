// SPDX-License-Identifier: MPL-2.0
#include "batten/core/bilinear_map.h"

#include "batten/tests/support/catch.h"
#include "batten/tests/support/sampling.h"

using namespace batten;
using batten_test::Random;

namespace {

// A convex quadrilateral: a unit square whose corners move by less than a quarter.
BilinearMap random_map(Random& random, const Vec2& extent) {
  std::array<Vec2, 4> corners{Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  for (Vec2& corner : corners) corner += 0.24 * Vec2(random(), random());
  return BilinearMap(corners, extent);
}

}  // namespace

TEST_CASE("a bilinear map takes sides to sides affinely, and its inverse returns the point",
          "[core]") {
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec2 extent(random.between(0.1, 3), random.between(0.1, 3));
    const BilinearMap map = random_map(random, extent);
    const Vec2 rectangle[4] = {{0, 0}, {extent.x(), 0}, extent, {0, extent.y()}};
    for (int k = 0; k < 4; ++k) {
      const int next = (k + 1) % 4;
      const double f = random.between(0, 1);
      const Vec2 on_side = (1 - f) * rectangle[k] + f * rectangle[next];
      CHECK((map.at(on_side) - (1 - f) * map.corner(k) - f * map.corner(next)).norm() < 1e-14);
    }
    const Vec2 p = Vec2(random.between(0, 1), random.between(0, 1)).cwiseProduct(extent);
    CHECK((map.inverse(map.at(p)) - p).norm() < 1e-12 * extent.norm());
    constexpr double h = 1e-5;
    for (int j = 0; j < 2; ++j) {
      const Vec2 step = h * Vec2::Unit(j);
      const Vec2 slope = (map.at(p + step) - map.at(p - step)) / (2 * h);
      CHECK((map.jacobian(p).col(j) - slope).norm() < 1e-9);
    }
  }
}
