// SPDX-License-Identifier: MPL-2.0
// Curves that several benchmarks skin.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/skinning/lines/character_line.h"

namespace batten::bench {

using Cubic = std::array<Vec3, 4>;  ///< Bézier control points

inline Vec3 cubic_point(const Cubic& c, double t) {
  const double s = 1 - t;
  return s * s * s * c[0] + 3 * s * s * t * c[1] + 3 * s * t * t * c[2] + t * t * t * c[3];
}

/// A loop of cubics, and inner cubics.
struct CurvedLoop {
  std::string name;
  std::vector<Cubic> outline, inner;
  double edge_length = 0;  ///< for a little over 1000 triangles
};

inline CurvedLoop pentagon() {
  const Vec3 corner[] = {
      {1, 0, 0}, {0.3, 0.95, 0.2}, {-0.8, 0.6, -0.1}, {-0.8, -0.6, 0.15}, {0.3, -0.95, -0.05}};
  return {"pentagon",
          {{corner[0], {0.9, 0.4, 0.15}, {0.65, 0.75, 0.3}, corner[1]},
           {corner[1], {-0.05, 1, 0.25}, {-0.5, 0.85, 0.1}, corner[2]},
           {corner[2], {-1, 0.25, -0.2}, {-0.95, -0.25, 0.2}, corner[3]},
           {corner[3], {-0.5, -0.85, 0.2}, {-0.1, -1, 0.05}, corner[4]},
           {corner[4], {0.6, -0.75, -0.15}, {0.95, -0.35, -0.1}, corner[0]}},
          {},
          0.0835};
}

inline CurvedLoop patch() {
  const Vec3 corner[] = {{0, 0, 0}, {2, 0, 0.1}, {2.1, 1.5, 0}, {-0.1, 1.4, 0.2}};
  CurvedLoop c{"patch with an inner curve",
               {{corner[0], {0.7, -0.1, 0.4}, {1.4, 0.05, 0.3}, corner[1]},
                {corner[1], {2.1, 0.5, 0.3}, {2.15, 1, 0.2}, corner[2]},
                {corner[2], {1.4, 1.6, 0.4}, {0.6, 1.3, 0.5}, corner[3]},
                {corner[3], {-0.15, 0.9, 0.4}, {-0.05, 0.5, 0.25}, corner[0]}},
               {},
               0.0955};
  c.inner = {{cubic_point(c.outline[3], 0.5),
              {0.6, 0.75, 0.55},
              {1.4, 0.7, 0.6},
              cubic_point(c.outline[1], 0.5)}};
  return c;
}

inline std::vector<CharacterLine> lines_of(const CurvedLoop& c) {
  std::vector<CharacterLine> lines;
  for (const Cubic& b : c.outline)
    lines.push_back({"side " + std::to_string(lines.size() + 1),
                     bezier_curve(b[0], b[1], b[2], b[3]), CharacterLine::Role::Outline});
  for (const Cubic& b : c.inner)
    lines.push_back({"across", bezier_curve(b[0], b[1], b[2], b[3]), CharacterLine::Role::Inner});
  return lines;
}

/// The four sides of a slightly arched square.
inline std::vector<CharacterLine> arched_plate() {
  const auto side = [](const Vec3& a, const Vec3& b) {
    const Vec3 rise(0, 0, 0.05);
    return bezier_curve(a, a + (b - a) / 3 + rise, a + 2 * (b - a) / 3 + rise, b);
  };
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
  return {{"south", side(a, b)}, {"east", side(b, c)}, {"north", side(c, d)}, {"west", side(d, a)}};
}

inline double wave(double x, double y) {
  return 0.15 * std::sin(2.1 * x + 0.3) * std::cos(1.7 * y);
}

/// Curves over the unit square with the height of wave(), `columns` × `rows` cells. Their
/// intersections agree only approximately: a network joins them within its tolerance.
inline std::vector<CharacterLine> wavy_grid(int columns, int rows) {
  const auto line = [](const std::string& name, bool along_x, double at) -> CharacterLine {
    constexpr int pieces = 12;
    std::vector<Vec3> points;
    for (int i = 0; i <= pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      points.push_back(along_x ? Vec3(s, at, wave(s, at)) : Vec3(at, s, wave(at, s)));
    }
    return {name, curve_through_points(name, points)};
  };
  std::vector<CharacterLine> lines;
  for (int i = 0; i <= columns; ++i)
    lines.push_back(line("x" + std::to_string(i), false, static_cast<double>(i) / columns));
  for (int i = 0; i <= rows; ++i)
    lines.push_back(line("y" + std::to_string(i), true, static_cast<double>(i) / rows));
  return lines;
}

}  // namespace batten::bench
