// SPDX-License-Identifier: MPL-2.0
#include <cmath>
#include <numbers>
#include <random>

#include "batten/fairing/corners/corners.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

using Numbers = std::vector<int>;

using std::numbers::pi;

std::vector<Vec3> arc(int points, double degrees) {
  std::vector<Vec3> all;
  for (int i = 0; i < points; ++i) {
    const double t = degrees * pi / 180 * i / (points - 1);
    all.emplace_back(50 * std::cos(t), 0, 50 * std::sin(t));
  }
  return all;
}

// A path of straight sides with given numbers of chords, which turns at its corners.
std::vector<Vec3> path(const std::vector<double>& turning_angles, int chords, double step = 1) {
  std::vector<Vec3> all{Vec3::Zero()};
  double heading = 0;
  for (size_t side = 0; side <= turning_angles.size(); ++side) {
    for (int k = 0; k < chords; ++k)
      all.push_back(all.back() + step * Vec3(std::cos(heading), std::sin(heading), 0));
    if (side < turning_angles.size()) heading += turning_angles[side] * pi / 180;
  }
  return all;
}

std::vector<Vec3> noisy(std::vector<Vec3> points, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (Vec3& p : points) p += Vec3(normal(random), normal(random), normal(random));
  return points;
}

}  // namespace

TEST_CASE("sparse points of an arc are no corners", "[fairing][corners]") {
  for (const double degrees : {30.0, 90.0, 180.0, 240.0})
    for (const int points : {5, 6, 9, 17, 60}) {
      INFO(points << " points of " << degrees);
      CHECK(find_corners(arc(points, degrees), false, 8).empty());
    }
  auto circle = arc(9, 360);
  circle.pop_back();
  CHECK(find_corners(circle, true, 20).empty());
}

TEST_CASE("corners stand out, between straight sides and at the ends of arcs",
          "[fairing][corners]") {
  CHECK(find_corners(path({90}, 2), false, 20) == Numbers{2});
  CHECK(find_corners(path({30, -45, 120}, 4), false, 20) == Numbers{4, 8, 12});
  CHECK(find_corners(path({10}, 8), false, 8) == Numbers{8});
  CHECK(find_corners(path({10}, 8), false, 20).empty());
  // Polygons given by their corners, including chamfered ones.
  CHECK(find_corners({{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}}, true, 20) ==
        Numbers{0, 1, 2, 3});
  CHECK(find_corners({{1, 0, 0},
                      {9, 0, 0},
                      {10, 1, 0},
                      {10, 5, 0},
                      {9, 6, 0},
                      {1, 6, 0},
                      {0, 5, 0},
                      {0, 1, 0}},
                     true, 20)
            .size() == 8);
  // A D shape: an arc and the line that closes it.
  std::vector<Vec3> d = arc(17, 180);
  CHECK(find_corners(d, true, 20) == Numbers{0, 16});
}

TEST_CASE("rounded corners and noses are none", "[fairing][corners]") {
  std::vector<Vec3> rounded;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i <= 4; ++i) {
      const double t = pi / 2 * (k + i / 4.0);
      rounded.emplace_back((k == 0 || k == 3 ? 42 : -42) + 8 * std::cos(t),
                           (k < 2 ? 22 : -22) + 8 * std::sin(t), 0);
    }
  CHECK(find_corners(rounded, true, 8).empty());
  // NACA 0012 at the usual stations: 77 degrees at the nose.
  std::vector<Vec3> wing;
  const double stations[] = {1,    0.95, 0.9,  0.8, 0.7,   0.6,  0.5,   0.4,   0.3,
                             0.25, 0.2,  0.15, 0.1, 0.075, 0.05, 0.025, 0.0125};
  const auto half = [](double x) {
    return 0.6 * (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x + 0.2843 * x * x * x -
                  0.1015 * x * x * x * x);
  };
  for (const double x : stations) wing.emplace_back(x, half(x), 0);
  wing.emplace_back(0, 0, 0);
  for (int i = 16; i >= 0; --i) wing.emplace_back(stations[i], -half(stations[i]), 0);
  CHECK(find_corners(wing, false, 8).empty());
  // Each half of it as a separate curve.
  CHECK(find_corners({wing.begin(), wing.begin() + 18}, false, 8).empty());
  CHECK(find_corners({wing.begin() + 17, wing.end()}, false, 8).empty());
  // A kink before the last chord is still detected.
  std::vector<Vec3> hook(wing.begin(), wing.begin() + 12);
  hook.push_back(hook.back() + Vec3(-0.04, -0.03, 0));
  CHECK(find_corners(hook, false, 8) == Numbers{11});
}

TEST_CASE("zigzags, stars and gears have a corner at every point", "[fairing][corners]") {
  const auto every = [](int first, int end) {
    Numbers all;
    for (int i = first; i < end; ++i) all.push_back(i);
    return all;
  };
  for (const double turn : {40.0, 60.0, 100.0}) {
    INFO(turn);
    const auto zigzag = path({turn / 2, -turn, turn, -turn, turn, -turn, turn / 2}, 1);
    CHECK(find_corners({zigzag.begin() + 1, zigzag.end() - 1}, false, 20) == every(1, 6));
    // In the middle of a straight line, and with uneven legs.
    const auto inside = path({0, 0, turn, -2 * turn, 2 * turn, -turn, 0, 0}, 1);
    CHECK(find_corners(inside, false, 20) == every(3, 7));
  }
  for (const int tips : {4, 5, 8, 24}) {
    INFO(tips);
    std::vector<Vec3> star;
    for (int i = 0; i < 2 * tips; ++i) {
      const double t = pi * i / tips, r = i % 2 ? 2 : 5;
      star.emplace_back(r * std::cos(t), r * std::sin(t), 0);
    }
    CHECK(find_corners(star, true, 20) == every(0, 2 * tips));
    CHECK(find_corners(star, true, 179).size() < star.size());
  }
  // A wave of few points is smooth: its turning angles grow and fade.
  std::vector<Vec3> wave;
  for (int i = 0; i <= 24; ++i) wave.emplace_back(i, 2 * std::sin(i * pi / 4), 0);
  CHECK(find_corners(wave, false, 20).empty());
  for (unsigned seed = 0; seed < 20; ++seed) {
    INFO(seed);
    CHECK(find_corners(noisy(path({}, 100), 0.5, seed), false, 20).empty());
  }
}

TEST_CASE("noise makes no corners, and hides none that stand far above it", "[fairing][corners]") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    INFO(seed);
    CHECK(find_corners(noisy(arc(80, 200), 0.2, seed), false, 8).empty());
    CHECK(find_corners(noisy(path({}, 100), 0.3, seed), false, 8).empty());
    const Numbers found = find_corners(noisy(path({80}, 40), 0.4, seed), false, 8);
    REQUIRE(found.size() == 1);
    CHECK(std::abs(found[0] - 40) <= 2);
  }
  // Thousands of points are examined by local means.
  const Numbers many = find_corners(noisy(path({60}, 2000, 0.01), 0.05, 3), false, 20);
  REQUIRE(many.size() == 1);
  CHECK(std::abs(many[0] - 2000) < 60);
}
