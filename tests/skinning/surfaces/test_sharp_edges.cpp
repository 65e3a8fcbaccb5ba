// SPDX-License-Identifier: MPL-2.0
// Solids with sharp edges as drawn.
#include <array>
#include <cmath>
#include <numbers>

#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/sample_networks.h"

using namespace batten;
using namespace batten_test;

namespace {

// A wedge along y from nine straight curves: a sharp edge at x = 0, 80 long, and a face at x = 50.
std::vector<CharacterLine> wedge_lines(double degrees, bool other_order) {
  const double h = 50 * std::tan(degrees * std::numbers::pi / 360);
  const auto corner = [&](int i, double y) {
    return i == 0 ? Vec3(0, y, 0) : Vec3(50, y, i == 1 ? -h : h);
  };
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    lines.push_back(straight("near " + std::to_string(i), corner(i, 0), corner(next, 0)));
    lines.push_back(straight("far " + std::to_string(i), corner(next, 80), corner(i, 80)));
    lines.push_back(straight("along " + std::to_string(i), corner(i, 0), corner(i, 80)));
  }
  if (other_order) std::reverse(lines.begin(), lines.end());
  return lines;
}

}  // namespace

TEST_CASE("wedges of nine curves have five faces, no defect and the volume of the solid",
          "[skinning][surfaces]") {
  ModelOptions options;
  options.skin.edge_length = 8;
  for (const double degrees : {60.0, 30.0, 16.0, 10.0, 5.0, 2.0})
    for (const bool other_order : {false, true}) {
      INFO(degrees << " degrees");
      const CurveNetwork network(wedge_lines(degrees, other_order));
      const SurfaceModel model = skin_network(network, find_regions(network), options);
      REQUIRE(model.regions.size() == 5);
      REQUIRE(model.shells.size() == 1);
      CHECK(model.shells[0].closed);
      CHECK(model.shells[0].normals.text() == "outwards");
      CHECK(model.defects.empty());
      for (const ModelJoin& join : model.joins) CHECK(join.kind == ModelJoin::Kind::Crease);
      const double volume = 50 * 50 * std::tan(degrees * std::numbers::pi / 360) * 80;
      CHECK(model.shells[0].volume == Approx(volume).epsilon(1e-6));
    }
}

TEST_CASE("a square-to-round adapter is the same at both ends, with arcs or one circle",
          "[skinning][surfaces]") {
  const double pi = std::numbers::pi;
  // Angles of the edges between its four sides.
  const auto angles = [&](bool flipped, bool one_circle, double radius) {
    const Vec3 low(0, 0, flipped ? 2 : 0), high(0, 0, flipped ? 0 : 2);
    std::vector<CharacterLine> lines;
    const auto arc = [&](const std::string& name, double from, double to) {
      return CharacterLine{name, curve_from_formula(from, to, [=](double t, int order) -> Vec3 {
                             const Vec3 x = radius * Vec3(std::cos(t), std::sin(t), 0),
                                        y = radius * Vec3(-std::sin(t), std::cos(t), 0);
                             return order == 0 ? Vec3(high + x) : order == 1 ? y : Vec3(-x);
                           })};
    };
    const auto square = [&](int i) {
      const double a = pi / 4 + i * pi / 2;
      return Vec3(low + std::sqrt(2.0) * Vec3(std::cos(a), std::sin(a), 0));
    };
    for (int i = 0; i < 4; ++i) {
      const double a = pi / 4 + i * pi / 2;
      lines.push_back(straight("side " + std::to_string(i), square(i), square(i + 1)));
      lines.push_back(straight("edge " + std::to_string(i), square(i),
                               high + radius * Vec3(std::cos(a), std::sin(a), 0)));
      if (!one_circle) lines.push_back(arc("arc " + std::to_string(i), a, a + pi / 2));
    }
    if (one_circle) lines.push_back(arc("circle", 0, 2 * pi));
    ModelOptions options;
    options.skin.edge_length = 0.3;
    const CurveNetwork network(lines);
    const SurfaceModel model = skin_network(network, find_regions(network), options);
    std::vector<std::pair<ModelJoin::Kind, double>> result;
    for (const ModelJoin& join : model.joins)
      if (join.line.starts_with("edge")) result.emplace_back(join.kind, join.initial_deg);
    return result;
  };
  for (const double radius : {0.7, 1.0, 1.3}) {
    const auto expected = angles(false, false, radius);
    REQUIRE(expected.size() == 4);
    for (const bool flipped : {false, true})
      for (const bool one_circle : {false, true}) {
        const auto found = angles(flipped, one_circle, radius);
        REQUIRE(found.size() == 4);
        for (size_t i = 0; i < 4; ++i) {
          CHECK(found[i].first == expected[0].first);
          CHECK(found[i].second == Approx(expected[0].second).margin(0.5));
        }
      }
  }
}
