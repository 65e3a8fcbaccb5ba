// SPDX-License-Identifier: MPL-2.0
// Lofts between sections with corners: which points correspond, and the surfaces between them.
#include "batten/skinning/surfaces/loft_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/surfaces/build_model.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/tests/support/aerofoil.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using namespace batten_test;

namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Vec3> regular(int count, double radius, double z, double phase = 0) {
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k) {
    const double a = phase + 2 * kPi * k / count;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return points;
}

CharacterLine straight_line(const std::string& name, const Vec3& from, const Vec3& to) {
  CharacterLine line;
  line.name = name;
  line.curve = bezier_curve(from, from + (to - from) / 3, to - (to - from) / 3, to);
  return line;
}

double area_of(const BuiltModel& made) { return made.model.area; }

}  // namespace

TEST_CASE("a frustum is exact for any start points and directions of its sections",
          "[skinning][surfaces]") {
  // Slant height of a face: from the apothems of both squares.
  const double r = std::sqrt(0.5), slant = std::hypot(2, r * (1 - 0.5));
  const double exact = 4 * slant * 0.5 * (2 * r + 2 * r * 0.5);
  for (const int seam : {0, 1, 3})
    for (const bool against : {false, true}) {
      const std::vector<CharacterLine> lines{
          closed_line("low", regular(4, 1, 0, kPi / 4)),
          closed_line("high", regular(4, 0.5, 2, kPi / 4), seam, against)};
      const BuiltModel made = build_model(lines, {});
      CHECK(made.region_names().size() == 4);
      CHECK(area_of(made) == Approx(exact).epsilon(1e-6));
    }
}

TEST_CASE("corners of a square get points on a circle at the nearest parameters",
          "[skinning][surfaces]") {
  const std::vector<CharacterLine> lines{closed_line("square", regular(4, 1, 0, kPi / 4)),
                                         closed_line("round", regular(60, 1, 2, 0.3), 7, true)};
  const CurveNetwork network(lines);
  const auto plan = find_loft(network);
  REQUIRE(plan);
  const std::vector<CharacterLine> rails = loft_rails(network, *plan);
  REQUIRE(rails.size() == 4);
  for (const CharacterLine& rail : rails) {
    const Vec3 a = rail.curve->evaluate(rail.curve->start()),
               b = rail.curve->evaluate(rail.curve->end());
    CHECK((a - b).head<2>().norm() < 1e-4);
    CHECK(std::abs(a.z() - b.z()) == Approx(2));
  }
  CHECK(build_model(lines, {}).region_names().size() == 4);
}

TEST_CASE("corners of twisted sections correspond to the nearest ones, however both are turned",
          "[skinning][surfaces]") {
  for (int k = 0; k < 9; ++k)
    for (const double twist : {-0.6, 0.6}) {
      const double phase = 0.1 + 0.2 * k;
      const CurveNetwork network({closed_line("low", regular(4, 1, 0, phase), k % 4, k % 2 == 1),
                                  closed_line("high", regular(4, 1, 2, phase + twist))});
      const auto plan = find_loft(network);
      REQUIRE(plan);
      const std::vector<CharacterLine> rails = loft_rails(network, *plan);
      REQUIRE(rails.size() == 4);
      for (const CharacterLine& rail : rails) {
        const Vec3 a = rail.curve->evaluate(rail.curve->start()),
                   b = rail.curve->evaluate(rail.curve->end());
        CHECK(a.head<2>().dot(b.head<2>()) == Approx(std::cos(twist)).epsilon(1e-6));
      }
    }
}

TEST_CASE("shallow corners that fade out stay creases, so that the loft is ruled",
          "[skinning][surfaces]") {
  // 16 corners of 22.5 degrees, and a circle.
  constexpr int kCorners = 16, kSteps = 200;
  std::vector<int> all;
  for (int k = 0; k <= kCorners; ++k) all.push_back(k);
  std::vector<Vec3> points = regular(kCorners, 1, 0, 0.05);
  points.push_back(points.front());
  CharacterLine polygon;
  polygon.name = "polygon";
  polygon.curve = curve_through_points("polygon", points, 20, all);
  const BuiltModel made = build_model({polygon, closed_line("circle", regular(90, 1, 0.5))}, {});
  const double step = 2 * kPi / kCorners;
  double exact = 0;
  for (int k = 0; k < kSteps; ++k)
    for (int j = 0; j < kSteps; ++j) {
      const auto at = [&](int i, int h) {
        const double s = i / double(kSteps), t = h / double(kSteps);
        const Vec3 a = (1 - s) * Vec3(1, 0, 0) + s * Vec3(std::cos(step), std::sin(step), 0);
        return Vec3((1 - t) * a + t * Vec3(std::cos(s * step), std::sin(s * step), 0.5));
      };
      exact +=
          kCorners * 0.5 * (at(k + 1, j + 1) - at(k, j)).cross(at(k, j + 1) - at(k + 1, j)).norm();
    }
  CHECK(made.region_names().size() == kCorners);
  CHECK(area_of(made) == Approx(exact).epsilon(1e-4));
}

TEST_CASE("a triangle and a hexagon correspond by their corners in order", "[skinning][surfaces]") {
  const std::vector<CharacterLine> lines{closed_line("three", regular(3, 1, 0), 1, true),
                                         closed_line("six", regular(6, 1.2, 1), 4)};
  const CurveNetwork network(lines);
  const auto plan = find_loft(network);
  REQUIRE(plan);
  const std::vector<CharacterLine> rails = loft_rails(network, *plan);
  REQUIRE(rails.size() == 6);
  int at_corners = 0;
  for (const CharacterLine& rail : rails) {
    Vec3 a = rail.curve->evaluate(rail.curve->start()), b = rail.curve->evaluate(rail.curve->end());
    if (a.z() > b.z()) std::swap(a, b);
    CHECK(a.head<2>().normalized().dot(b.head<2>().normalized()) == Approx(1).margin(1e-6));
    at_corners += a.norm() > 0.999;
  }
  CHECK(at_corners == 3);
}

TEST_CASE("a wing of root, tip and one edge equals the wing with both edges",
          "[skinning][surfaces]") {
  const std::vector<CharacterLine> ribs{closed_line("root", aerofoil(30, 1, 0), 11),
                                        closed_line("tip", aerofoil(24, 0.6, 3), 5, true)};
  const CharacterLine leading = straight_line("leading", {0, 0, 0}, {0, 3, 0}),
                      trailing = straight_line("trailing", {0.6, 3, 0}, {1, 0, 0});
  const auto volume = [&](std::vector<CharacterLine> edges) {
    edges.insert(edges.end(), ribs.begin(), ribs.end());
    const BuiltModel made = build_model(edges, {});
    REQUIRE(made.model.shells.size() == 1);
    CHECK(made.region_names().size() == 4);
    CHECK(made.model.shells[0].closed);
    return made.model.shells[0].volume;
  };
  const double both = volume({leading, trailing});
  // Area of the profile: 0.6 times the integral of its polynomial, twice.
  const double profile = 1.2 * (0.2969 * 2 / 3 - 0.126 / 2 - 0.3516 / 3 + 0.2843 / 4 - 0.1036 / 5);
  CHECK(both == Approx(profile * (1 + 0.6 + 0.36)).epsilon(2e-3));
  CHECK(volume({leading}) == Approx(both).epsilon(1e-3));
  CHECK(volume({trailing}) == Approx(both).epsilon(1e-3));
}

TEST_CASE("the face between two guides of a wing runs around the nose", "[skinning][surfaces]") {
  // Its area is three times that of the flat web between the guides.
  constexpr int kCount = 30;
  const std::vector<Vec3> root = aerofoil(kCount, 1, 0), tip = aerofoil(kCount, 0.6, 3);
  const auto volume = [&](const std::vector<int>& guides) {
    std::vector<CharacterLine> lines{closed_line("root", root), closed_line("tip", tip)};
    for (const int k : guides)
      lines.push_back(straight_line("guide " + std::to_string(k), root[k], tip[k]));
    const BuiltModel made = build_model(lines, {});
    CHECK(made.model.defects.empty());
    REQUIRE(made.model.shells.size() == 1);
    CHECK(made.model.shells[0].closed);
    return made.model.shells[0].volume;
  };
  CHECK(volume({kCount / 2, 3 * kCount / 2}) == Approx(volume({0, kCount})).epsilon(1e-3));
}

TEST_CASE("the tail of a small profile is not joined by the gap tolerance of a long wing",
          "[skinning][surfaces]") {
  const std::vector<CharacterLine> ribs{closed_line("root", aerofoil(60, 1, 0)),
                                        closed_line("tip", aerofoil(60, 0.15, 10))};
  const CurveNetwork network(ribs);
  CHECK(network.edges().size() == 2);
  CHECK(find_loft(network));
}

TEST_CASE("short sides of a polyline are kept, and its thin parts are not joined",
          "[skinning][surfaces]") {
  const auto polyline = [](const std::string& name, std::vector<Vec3> points) {
    points.push_back(points.front());
    std::vector<int> all(points.size());
    for (size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    CharacterLine line;
    line.name = name;
    line.curve = curve_through_points(name, points, 20, all);
    return line;
  };
  constexpr int kCount = 20;
  const CurveNetwork network(
      {polyline("root", aerofoil(kCount, 1, 0)), polyline("tip", aerofoil(kCount, 0.3, 10))});
  CHECK(network.edges().size() == 4 * kCount);
  CHECK(find_loft(network));
}

TEST_CASE("curves that are no row of sections get no rails", "[skinning][surfaces]") {
  // Beside each other in a plane; smooth; one alone.
  std::vector<Vec3> beside = regular(4, 1, 0);
  for (Vec3& p : beside) p.x() += 5;
  CHECK_FALSE(
      find_loft(CurveNetwork({closed_line("a", regular(4, 1, 0)), closed_line("b", beside)})));
  CHECK_FALSE(find_loft(
      CurveNetwork({closed_line("a", regular(40, 1, 0)), closed_line("b", regular(40, 1, 2))})));
  CHECK_FALSE(find_loft(CurveNetwork({closed_line("a", regular(4, 1, 0))})));
}

TEST_CASE("open sections with a chine get a crease along it", "[skinning][surfaces]") {
  const auto station = [](const std::string& name, double x, double width, bool against) {
    std::vector<Vec3> points{{x, 0, 0}, {x, width, 0.3}, {x, 1.2 * width, 1}};
    if (against) std::reverse(points.begin(), points.end());
    CharacterLine line;
    line.name = name;
    line.curve = curve_through_points(name, points, 20, std::vector<int>{1});
    return line;
  };
  const BuiltModel made = build_model({station("a", 0, 1, false), station("b", 3, 0.8, true)}, {});
  REQUIRE(made.network);
  CHECK(made.region_names().size() == 2);
  CHECK(made.network->edges_of("rail 2").size() == 1);
}
