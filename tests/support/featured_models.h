// SPDX-License-Identifier: MPL-2.0
// Models with feature regions and an edit, for tests of deformers.
#pragma once

#include <string>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/mesh/regions/feature_region_deformer.h"
#include "batten/tests/support/region_meshes.h"

namespace batten_test {

struct FeaturedModel {
  std::string name;
  TriangleMesh mesh;
  std::vector<int> fixed;
  std::vector<Handle> handles;
  std::vector<HandleTransform> moves;
  std::vector<FeatureRegion> regions;
  std::vector<int> ring = {};  // sheet around the only region; none: not measured
};

/// Motion of the far end of a strip from `start` to `end` when the strip is bent to an arc about
/// `axis`, which is perpendicular to it.
inline HandleTransform bent_to_arc(const Vec3& start, const Vec3& end, const Vec3& axis,
                                   double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3 along = end - start, across = axis.normalized().cross(along);
  HandleTransform move;
  move.about = end;
  move.rotation_vector = to_rotation_vector(axis, angle);
  move.translation = (std::sin(angle) * along + (1 - std::cos(angle)) * across) / angle - along;
  return move;
}

/// BossPanel with its side lifted without rotation.
inline FeaturedModel lifted_panel(int n) {
  const BossPanel panel(n);
  return {"panel with a boss, lifted", panel.mesh, panel.fixed, panel.handles, panel.lift(1.2),
          {{"boss", {}, panel.boss}},  panel.ring};
}

/// A flat wall [0, 12] × [0, 3], `per_unit` squares per unit, with the letters T E H raised by 0.2
/// on walls of width 0.1. Its far end is bent by 75 degrees about the vertical axis.
inline FeaturedModel wall_with_letters(int per_unit) {
  struct Stroke {
    double left, bottom, right, top;
  };
  struct Letter {
    std::string name;
    double at;  // left side
    std::vector<Stroke> strokes;
  };
  const std::vector<Letter> letters = {
      {"T", 1.8, {{0, 1.7, 1.6, 2.2}, {0.55, 0.8, 1.05, 2.2}}},
      {"E",
       5.2,
       {{0, 0.8, 0.4, 2.2}, {0, 0.8, 1.6, 1.1}, {0, 1.35, 1.3, 1.65}, {0, 1.9, 1.6, 2.2}}},
      {"H", 8.6, {{0, 0.8, 0.5, 2.2}, {1.1, 0.8, 1.6, 2.2}, {0, 1.3, 1.6, 1.7}}}};
  const auto outside = [](const Letter& letter, double x, double y) {
    double least = 1e9;
    for (const Stroke& s : letter.strokes)
      least = std::min(least, std::max({letter.at + s.left - x, x - letter.at - s.right,
                                        s.bottom - y, y - s.top}));
    return least;
  };
  const int columns = 12 * per_unit, rows = 3 * per_unit;
  Points p((columns + 1L) * (rows + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = b + columns + 1, d = c - 1;
      const double x = static_cast<double>(i) / per_unit, y = static_cast<double>(j) / per_unit;
      double height = 0;
      for (const Letter& letter : letters)
        height = std::max(height, 0.2 * std::clamp(1 - outside(letter, x, y) / 0.1, 0.0, 1.0));
      p.row(a) << x, y, height;
      if (i == columns || j == rows) continue;
      if ((i + j) % 2)
        triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
      else
        triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
    }
  FeaturedModel model{"wall with letters, bent", TriangleMesh(p, triangles), {}, {}, {}, {}};
  const auto& mesh = model.mesh;
  model.fixed = vertices_where(mesh, [](const Vec3& q) { return q.x() < 0.6 + 1e-9; });
  model.handles = {
      {"end", vertices_where(mesh, [](const Vec3& q) { return q.x() > 11.4 - 1e-9; })}};
  model.moves = {bent_to_arc({0.6, 1.5, 0}, {11.4, 1.5, 0}, -Vec3::UnitY(), 75)};
  for (const Letter& letter : letters)
    model.regions.push_back({letter.name, {}, vertices_where(mesh, [&](const Vec3& q) {
                               return outside(letter, q.x(), q.y()) < 0.1 + 1e-9;
                             })});
  return model;
}

/// An open tube of length 12 that tapers from radius 1 to 0.35, with `around` nearly regular
/// squares around it, and ten rings of six suckers: low bumps with a dent. Curled by 120 degrees:
/// its tip is rotated and moved to the end of a circular arc.
inline FeaturedModel arm_with_suckers(int around) {
  constexpr double kLength = 12, kBase = 1, kTip = 0.35, kSucker = 0.3, kHeight = 0.15;
  constexpr int kRings = 10, kEach = 6;
  constexpr double kSlope = (kBase - kTip) / kLength;
  // (s, phi) is conformal: a step ds has the length of the same step around, both times the radius.
  const double end = std::log(kBase / kTip) / kSlope;
  const auto along = static_cast<int>(std::lround(end * around / (2 * std::numbers::pi)));
  const auto centre = [&](int ring, int k) {
    return Vec2(end * (ring + 1) / (kRings + 1),
                2 * std::numbers::pi * (k + 0.5 * (ring % 2)) / kEach);
  };
  const auto off = [](const Vec2& from, double s, double phi) {
    return std::hypot(s - from.x(), std::remainder(phi - from.y(), 2 * std::numbers::pi));
  };
  std::vector<FeatureRegion> regions;
  for (int k = 0; k < kRings * kEach; ++k)
    regions.push_back({"sucker " + std::to_string(k + 1), {}, {}});
  Points p((along + 1L) * around, 3);
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i < around; ++i) {
      const int a = j * around + i, b = j * around + (i + 1) % around, c = b + around,
                d = a + around;
      const double s = end * j / along, phi = 2 * std::numbers::pi * i / around;
      const double radius = kBase * std::exp(-kSlope * s);
      double bump = 0;
      for (int k = 0; k < kRings * kEach; ++k) {
        const double r = off(centre(k / kEach, k % kEach), s, phi) / kSucker;
        if (r > 1 - 1e-9) continue;
        regions[k].vertices.push_back(a);
        bump = 4 * r * r * (1 - r * r) + 0.5 * (1 - r * r) * (1 - r * r);
      }
      const double reach = radius * (1 + kHeight * bump);
      p.row(a) << (kBase - radius) / kSlope, reach * std::cos(phi), reach * std::sin(phi);
      if (j == along) continue;
      if ((i + j) % 2)
        triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
      else
        triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
    }
  FeaturedModel model{"arm with suckers, curled", TriangleMesh(p, triangles), {}, {}, {}, regions};
  model.fixed = vertices_where(model.mesh, [](const Vec3& q) { return q.x() < 0.4; });
  model.handles = {{"tip", vertices_where(model.mesh, [](const Vec3& q) { return q.x() > 11.7; })}};
  model.moves = {bent_to_arc({0.4, 0, 0}, {11.7, 0, 0}, Vec3::UnitZ(), 120)};
  return model;
}

/// A bar of length 8 and width 1 with four round patches in its faces, its end twisted by 135
/// degrees.
inline FeaturedModel twisted_bar(int across) {
  const Bar bar(8, across);
  FeaturedModel model{
      "bar, twisted by 135 degrees", bar.mesh, bar.fixed, bar.handles, Bar::twist(135), {}};
  const Vec3 centres[] = {
      {8 / 3.0, 0, 0.5}, {8 / 3.0, 0, -0.5}, {16 / 3.0, 0.5, 0}, {16 / 3.0, -0.5, 0}};
  for (const Vec3& c : centres)
    model.regions.push_back(
        {"patch " + std::to_string(model.regions.size() + 1),
         {},
         vertices_where(bar.mesh, [&](const Vec3& p) { return (p - c).norm() < 0.3; })});
  return model;
}

}  // namespace batten_test
