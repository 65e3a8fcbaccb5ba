// SPDX-License-Identifier: MPL-2.0
// Faces from sections alone.
#include "batten/skinning/surfaces/section_region.h"

#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/tests/support/catch.h"

using namespace batten;
using Catch::Matchers::Contains;

namespace {

// A hull: half-breadth (1 - (x/2)²)(1 - z²), z from -1 to 0, over x from -1.6 to 1.6.
double breadth(double x, double z) { return (1 - x * x / 4) * (1 - z * z); }

CharacterLine section(int number, double x, bool downwards) {
  std::vector<Vec3> points;
  constexpr int pieces = 40;
  for (int i = 0; i <= pieces; ++i) {
    const double f = static_cast<double>(i) / pieces, z = downwards ? -f : f - 1;
    points.emplace_back(x, breadth(x, z) + 0.2, z);
  }
  CharacterLine line;
  line.name = "section " + std::to_string(number);
  line.curve = curve_through_points(line.name, points);
  return line;
}

std::vector<CharacterLine> hull_sections(int count) {
  std::vector<CharacterLine> sections;
  for (int k = 0; k < count; ++k)
    sections.push_back(section(k + 1, -1.6 + 3.2 * k / (count - 1), k % 2 == 1));
  return sections;
}

}  // namespace

TEST_CASE("open splines reproduce cubics, parabolas through three points, lines through two",
          "[skinning][layout]") {
  const auto cubic = [](double u) { return Vec3(u, u * u - u, u * u * u - 2 * u + 1); };
  const auto slope = [](double u) { return Vec3(1, 2 * u - 1, 3 * u * u - 2); };
  const std::vector<double> u{0, 0.3, 1.1, 1.5, 2.7};
  Points x(5, 3);
  for (int i = 0; i < 5; ++i) x.row(i) = cubic(u[static_cast<size_t>(i)]);
  const Points m = not_a_knot_slopes(u, x);
  for (int i = 0; i < 5; ++i)
    CHECK((Vec3(m.row(i)) - slope(u[static_cast<size_t>(i)])).norm() < 1e-12);

  const std::vector<double> three{0, 1, 3};
  Points p(3, 3);
  for (int i = 0; i < 3; ++i)
    p.row(i) << 1, three[static_cast<size_t>(i)], std::pow(three[static_cast<size_t>(i)], 2);
  const Points parabola = not_a_knot_slopes(three, p);
  for (int i = 0; i < 3; ++i)
    CHECK((Vec3(parabola.row(i)) - Vec3(0, 1, 2 * three[static_cast<size_t>(i)])).norm() < 1e-12);
  const Points straight = not_a_knot_slopes({0, 2}, p.topRows(2));
  CHECK((straight.row(0) - (p.row(1) - p.row(0)) / 2).norm() < 1e-14);
  CHECK((straight.row(1) - straight.row(0)).norm() < 1e-14);
}

TEST_CASE("a hull comes back from five sections in either direction, without rails",
          "[skinning][layout]") {
  SkinOptions options;
  options.edge_length = 0.12;
  const ModelLayout model(section_region("hull", hull_sections(5), options));
  CHECK(model.has_line("rail 1"));
  CHECK(model.has_line("rail 2"));
  REQUIRE(model.region(0).corners().size() == 4);
  const Points loft = loft_shape(model, {"section 1", "section 2", "section 3"});
  CHECK(model.line_constraints().max_residual(loft) < 1e-10);
  const auto error = [&](const Points& dofs) {
    const Surface surface = model.surface(dofs);
    double worst = 0;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      const Vec3 x = surface.position({t, Vec3::Constant(1.0 / 3)});
      worst = std::max(worst, std::abs(x.y() - 0.2 - breadth(x.x(), x.z())));
    }
    return worst;
  };
  CHECK(error(loft) < 6e-3);  // that of the splines through five points
  CHECK(error(model.minimize_energy({})) > 5 * error(loft));
}

TEST_CASE("an annulus through circles of a sphere is the sphere, also near its boundaries",
          "[skinning][layout]") {
  std::vector<CharacterLine> circles;
  for (const double degrees : {-50, -30, -10, 10, 30, 50}) {
    const double latitude = degrees * std::numbers::pi / 180;
    std::vector<Vec3> points;
    constexpr int pieces = 48;
    for (int i = 0; i <= pieces; ++i) {
      const double a = 2 * std::numbers::pi * (i % pieces) / pieces;
      points.emplace_back(std::cos(latitude) * std::cos(a), std::cos(latitude) * std::sin(a),
                          std::sin(latitude));
    }
    CharacterLine& line = circles.emplace_back();
    line.name = "circle " + std::to_string(circles.size());
    line.curve = curve_through_points(line.name, points, 60);
  }
  const ModelLayout model(section_region("band", circles, {}));
  const Points loft = loft_shape(model, {"circle 1"});
  const Surface surface = model.surface(loft);
  double worst = 0;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t)
    worst = std::max(worst, std::abs(surface.position({t, Vec3::Constant(1.0 / 3)}).norm() - 1));
  CHECK(worst < 1e-3);
}

TEST_CASE("sections that form no face are refused with the reason", "[skinning][layout]") {
  CHECK_THROWS_WITH(section_lines({section(1, 0, false)}), Contains("expected two or more"));
  CHECK_THROWS_WITH(section_lines({section(1, 0, false), section(2, 0, true)}),
                    Contains("'section 2' shares an end with the section before it"));
  CharacterLine circle;
  circle.name = "circle";
  circle.curve = curve_from_formula(0, 2 * std::numbers::pi, [](double t, int order) -> Vec3 {
    const double at = t + order * std::numbers::pi / 2;
    return {std::cos(at), std::sin(at), order == 0 ? 3.0 : 0.0};
  });
  CHECK_THROWS_WITH(section_lines({section(1, 0, false), circle}),
                    Contains("'circle' is closed") && Contains("expected all open or all closed"));
}
