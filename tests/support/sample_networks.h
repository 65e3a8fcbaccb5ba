// SPDX-License-Identifier: MPL-2.0
// Networks that several tests skin.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/lines/character_line.h"

namespace batten_test {

using namespace batten;

inline CharacterLine straight(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_through_points(name, {a, b})};
}

/// The twelve edges of a box: x1 … x4 along x, y1 … along y, z1 … along z.
inline std::vector<CharacterLine> box_lines(const Vec3& low, const Vec3& size) {
  std::vector<CharacterLine> lines;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 4; ++i) {
      Vec3 a = low;
      if (i & 1) a[(axis + 1) % 3] += size[(axis + 1) % 3];
      if (i & 2) a[(axis + 2) % 3] += size[(axis + 2) % 3];
      Vec3 b = a;
      b[axis] += size[axis];
      lines.push_back(straight(std::string(1, "xyz"[axis]) + std::to_string(i + 1), a, b));
    }
  return lines;
}

/// Three great circles of a sphere, each one closed curve: "xy", "yz", "zx".
inline std::vector<CharacterLine> sphere_lines(double radius = 1) {
  std::vector<CharacterLine> lines;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 a = radius * Vec3::Unit(axis), b = radius * Vec3::Unit((axis + 1) % 3);
    lines.push_back(
        {std::string{"xyz"[axis], "xyz"[(axis + 1) % 3]},
         curve_from_formula(0, 2 * std::numbers::pi, [a, b](double t, int order) -> Vec3 {
           if (order == 0) return a * std::cos(t) + b * std::sin(t);
           if (order == 1) return -a * std::sin(t) + b * std::cos(t);
           return -a * std::cos(t) - b * std::sin(t);
         })});
  }
  return lines;
}

}  // namespace batten_test
