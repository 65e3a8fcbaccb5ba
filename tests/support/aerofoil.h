// SPDX-License-Identifier: MPL-2.0
// Aerofoil sections for tests of lofts.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/lines/character_line.h"

namespace batten_test {

/// A symmetric aerofoil (NACA 0012 with a closed tail) in the plane of constant y, with its sharp
/// tail at (chord, y, 0): upper side from tail to nose, then the lower side back.
inline std::vector<batten::Vec3> aerofoil(int count, double chord, double y) {
  std::vector<batten::Vec3> points;
  for (int k = 0; k < 2 * count; ++k) {
    const double b = std::numbers::pi * k / count, x = 0.5 * (1 + std::cos(b));
    const double half = 0.6 * (0.2969 * std::sqrt(x) - 0.126 * x - 0.3516 * x * x +
                               0.2843 * x * x * x - 0.1036 * x * x * x * x);
    points.emplace_back(chord * x, y, chord * (k < count ? half : -half));
  }
  return points;
}

/// A closed curve through points, with another start point and direction.
inline batten::CharacterLine closed_line(const std::string& name, std::vector<batten::Vec3> points,
                                         int seam = 0, bool against = false) {
  std::rotate(points.begin(), points.begin() + seam, points.end());
  if (against) std::reverse(points.begin(), points.end());
  points.push_back(points.front());
  batten::CharacterLine line;
  line.name = name;
  line.curve = batten::curve_through_points(name, points);
  return line;
}

}  // namespace batten_test
