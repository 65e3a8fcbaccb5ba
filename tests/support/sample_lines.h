// SPDX-License-Identifier: MPL-2.0
// Curves that several tests skin.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/layout/region_layout.h"

namespace batten_test {

using namespace batten;

/// Straight curves around a polygon in space.
inline std::vector<CharacterLine> polygon_lines(const std::vector<Vec3>& corners) {
  std::vector<CharacterLine> lines;
  for (size_t i = 0; i < corners.size(); ++i)
    lines.push_back(
        {"side " + std::to_string(i + 1),
         curve_through_points("side", {corners[i], corners[(i + 1) % corners.size()]})});
  return lines;
}

/// N cubic sides around a circle of radius 1, corners alternately up and down by `wave`, sides
/// bulging outwards by `bulge`; all lengths times `unit`.
inline std::vector<CharacterLine> curved_polygon(int n, double wave, double bulge,
                                                 double unit = 1) {
  std::vector<Vec3> corner;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n;
    corner.emplace_back(std::cos(t), std::sin(t), wave * std::cos(2 * t));
  }
  std::vector<CharacterLine> lines;
  for (int i = 0; i < n; ++i) {
    const Vec3 &a = corner[i], &b = corner[(i + 1) % n];
    const Vec3 out = bulge * (0.5 * (a + b)).normalized();
    lines.push_back({"side " + std::to_string(i + 1),
                     bezier_curve(unit * a, unit * (a + (b - a) / 3 + out),
                                  unit * (a + 2 * (b - a) / 3 + out), unit * b)});
  }
  return lines;
}

/// A four-sided patch of cubics with an inner cubic from the middle of side 1 to the middle of side
/// 3.
inline std::vector<CharacterLine> patch_with_inner_line() {
  const auto p = [](double x, double y, double z) { return Vec3(x, y, z); };
  const auto bottom = bezier_curve(p(0, 0, 0), p(0.5, -0.1, 0.3), p(1.1, -0.1, 0.3), p(1.6, 0, 0));
  const auto top = bezier_curve(p(1.6, 1.2, 0.1), p(1.1, 1.3, 0.3), p(0.5, 1.3, 0.4), p(0, 1.2, 0));
  const Vec3 a = bottom->evaluate(0.5), b = top->evaluate(0.5);
  return {
      {"bottom", bottom},
      {"right", bezier_curve(p(1.6, 0, 0), p(1.7, 0.4, 0.1), p(1.7, 0.8, 0.2), p(1.6, 1.2, 0.1))},
      {"top", top},
      {"left", bezier_curve(p(0, 1.2, 0), p(-0.1, 0.8, 0.1), p(-0.1, 0.4, 0.1), p(0, 0, 0))},
      {"rib", bezier_curve(a, a + p(0, 0.4, 0.25), b + p(0, -0.4, 0.25), b),
       CharacterLine::Role::Inner}};
}

}  // namespace batten_test
