// SPDX-License-Identifier: MPL-2.0
// Rotations of nodes between two shapes.
#include "batten/mesh/node_rotations.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <Eigen/Geometry>

#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

/// A strip of nx × 2 quads, and a chain of beams beside it.
struct Strip {
  static constexpr int nx = 20;
  ShellMesh shells;
  std::vector<NonShellElement> beams;
  static int node(int i, int j) { return 3 * i + j; }

  Strip() {
    const int chain = 5, first = 3 * (nx + 1);
    shells.points.resize(first + chain, 3);
    for (int i = 0; i <= nx; ++i)
      for (int j = 0; j < 3; ++j) shells.points.row(node(i, j)) = Vec3(i, j, 0).transpose();
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < 2; ++j)
        shells.add_face(std::array{node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)});
    for (int k = 0; k < chain; ++k) {
      shells.points.row(first + k) = Vec3(2 * k, 50, 7).transpose();
      if (k > 0)
        beams.push_back({NonShellElement::Kind::Beam, "CBAR", k, {first + k - 1, first + k}, {}});
    }
  }
  template <class Move>
  Points moved(const Move& move) const {
    Points p = shells.points;
    for (int i = 0; i < p.rows(); ++i) p.row(i) = move(Vec3(p.row(i).transpose())).transpose();
    return p;
  }
};

}  // namespace

TEST_CASE("node rotations reproduce rigid motions, of shells and of lines", "[mesh]") {
  const Strip strip;
  const Mat3 R = Eigen::AngleAxisd(2.5, Vec3(1, -2, 3).normalized()).toRotationMatrix();
  const Points after = strip.moved([&](const Vec3& p) { return Vec3(R * p + Vec3(100, 3, -9)); });
  const NodeRotations rotations(strip.shells, strip.beams, strip.shells.points, after);
  for (const int v : {0, 7, 30, 62}) {
    const auto motion = rotations.of(std::array{v});
    CHECK((motion.R - R).norm() < 1e-12);
    CHECK((motion.translation - Vec3(100, 3, -9)).norm() < 1e-9);
  }
  // On a line only the rotation of the line is known.
  const int beam = 3 * (Strip::nx + 1) + 2;
  CHECK((rotations.of(std::array{beam}).R * Vec3::UnitX() - R * Vec3::UnitX()).norm() < 1e-12);
  std::vector<int> all(static_cast<size_t>(3 * (Strip::nx + 1)));
  std::iota(all.begin(), all.end(), 0);
  const auto whole = rotations.of(all);
  CHECK(whole.spread < 1e-7);
  CHECK(whole.is_rotated);
}

TEST_CASE("translations are no rotations, in spite of rounding", "[mesh]") {
  const Strip strip;
  const Points after = strip.moved([](const Vec3& p) { return Vec3(p + Vec3(0.1, 1e4 / 3, 0)); });
  const NodeRotations rotations(strip.shells, strip.beams, strip.shells.points, after);
  for (const int v : {0, 31, 62}) {
    CHECK_FALSE(rotations.of(std::array{v}).is_rotated);
    CHECK(rotations.of(std::array{v}).R == Mat3::Identity());
  }
  const NodeRotations none(strip.shells, strip.beams, strip.shells.points, strip.shells.points);
  CHECK(none.of(std::array{5}).is_identity);
}

TEST_CASE("node rotations of a bend are exact to second order, also at its ends", "[mesh]") {
  const Strip strip;
  const double radius = Strip::nx / (std::numbers::pi / 2);
  const Points after = strip.moved([&](const Vec3& p) {
    if (p.y() > 10) return p;
    const double a = p.x() / radius;
    return Vec3(radius * std::sin(a), p.y(), radius * (1 - std::cos(a)));
  });
  const NodeRotations rotations(strip.shells, strip.beams, strip.shells.points, after);
  for (int i = 0; i <= Strip::nx; ++i)
    for (int j = 0; j < 3; ++j) {
      const double a = i / radius;
      const Vec3 normal = rotations.of(std::array{Strip::node(i, j)}).R * Vec3::UnitZ();
      INFO(i << " " << j);
      CHECK((normal - Vec3(-std::sin(a), 0, std::cos(a))).norm() < 2e-3);
    }
}

TEST_CASE("node rotations are continuous", "[mesh]") {
  const Strip strip;
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  const Points after = strip.moved([](const Vec3& p) {
    return Vec3(p.x(), p.y() * std::cos(0.1 * p.x()), p.y() * std::sin(0.1 * p.x()));
  });
  const NodeRotations rotations(strip.shells, strip.beams, strip.shells.points, after);
  for (const double size : {1e-12, 1e-9, 1e-6, 1e-3}) {
    Points disturbed = after;
    for (int i = 0; i < disturbed.rows(); ++i)
      for (int c = 0; c < 3; ++c) disturbed(i, c) += size * noise(random);
    const NodeRotations others(strip.shells, strip.beams, strip.shells.points, disturbed);
    for (const int v : {0, 1, 30, 31, 62})
      CHECK((others.of(std::array{v}).R - rotations.of(std::array{v}).R).norm() <
            20 * size + 1e-12);
  }
}
