// SPDX-License-Identifier: MPL-2.0
// Models for tests of STEP files.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten_test {

using namespace batten;

constexpr double kMm = 0.001;

inline CharacterLine straight(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_through_points(name, {a, b})};
}

/// Edges of a box [0, size], every second one backwards: "x00", "y10", …
inline std::vector<CharacterLine> box(const Vec3& size, const std::string& prefix = "",
                                      const Vec3& at = Vec3::Zero()) {
  std::vector<CharacterLine> lines;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) {
      const int second = (axis + 1) % 3, third = (axis + 2) % 3;
      Vec3 from = at;
      from[second] += (k & 1) * size[second];
      from[third] += (k >> 1) * size[third];
      Vec3 to = from;
      to[axis] += size[axis];
      if (k & 1) std::swap(from, to);
      lines.push_back(straight(prefix + "xyz"[axis] + std::to_string(k), from, to));
    }
  return lines;
}

/// Two boxes of the same size, adjacent in x, with a wall between them.
inline std::vector<CharacterLine> two_boxes() {
  std::vector<CharacterLine> lines = box({10, 10, 10}, "a");
  for (const CharacterLine& line : box({10, 10, 10}, "b", {10, 0, 0})) {
    const Vec3 middle = line.curve->evaluate(0.5 * (line.curve->start() + line.curve->end()));
    if (middle.x() > 10.1) lines.push_back(line);
  }
  return lines;
}

/// Closed circle around the z axis, from a start angle.
inline CharacterLine circle_line(const std::string& name, double radius, double z,
                                 double from = 0) {
  return {name, curve_from_formula(from, from + 2 * std::numbers::pi, [=](double t, int order) {
            const double c = std::cos(t), s = std::sin(t);
            return order == 0   ? Vec3(radius * c, radius * s, z)
                   : order == 1 ? Vec3(-radius * s, radius * c, 0)
                                : Vec3(-radius * c, -radius * s, 0);
          })};
}

/// Closed curve around the z axis with three bulges, from a start angle.
inline CharacterLine oval_line(const std::string& name, double z, double begin) {
  const auto curve = curve_from_formula(0, 2 * std::numbers::pi, [=](double t, int order) {
    const double a = t + begin, r = 10 + std::cos(3 * a), r1 = -3 * std::sin(3 * a),
                 r2 = -9 * std::cos(3 * a);
    const Vec3 e(std::cos(a), std::sin(a), 0), n(-e.y(), e.x(), 0);
    return order == 0   ? Vec3(r * e + Vec3(0, 0, z))
           : order == 1 ? Vec3(r1 * e + r * n)
                        : Vec3((r2 - r) * e + 2 * r1 * n);
  });
  return CharacterLine{name, curve};
}

/// Quarter of a great circle from one axis direction to another.
inline CharacterLine quarter(const std::string& name, const Vec3& a, const Vec3& b) {
  return {name, curve_from_formula(0, std::numbers::pi / 2, [=](double t, int order) {
            const double c = std::cos(t), s = std::sin(t);
            return order == 0   ? Vec3(c * a + s * b)
                   : order == 1 ? Vec3(-s * a + c * b)
                                : Vec3(-c * a - s * b);
          })};
}

/// Twelve quarters of great circles: the edges of eight octants of a ball.
inline std::vector<CharacterLine> octants() {
  std::vector<CharacterLine> lines;
  const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  for (int a = 0; a < 3; ++a)
    for (int k = 0; k < 4; ++k) {
      const int b = (a + 1) % 3;
      lines.push_back(quarter("q" + std::to_string(4 * a + k), (k & 1 ? -1 : 1) * axes[a],
                              (k & 2 ? -1 : 1) * axes[b]));
    }
  return lines;
}

/// Faces by their curves; two loops make an annulus.
inline RegionSearchOptions region_specs(
    const std::vector<std::vector<std::vector<std::string>>>& regions) {
  RegionSearchOptions options;
  for (const auto& loops : regions) {
    RegionSpec spec;
    spec.name = "r" + std::to_string(options.specs.size());
    spec.loops = loops;
    spec.annulus = loops.size() == 2;
    options.specs.push_back(spec);
  }
  return options;
}

struct BuiltModel {
  CurveNetwork network;
  SurfaceModel model;
};

inline BuiltModel build_model(const std::vector<CharacterLine>& lines,
                              const RegionSearchOptions& regions = {}, double edge_length = 0,
                              const NetworkOptions& how = {}) {
  CurveNetwork network(lines, how);
  ModelOptions options;
  options.skin.edge_length = edge_length > 0 ? edge_length : network.size() / 10;
  SurfaceModel model = skin_network(network, find_regions(network, regions), options);
  return {std::move(network), std::move(model)};
}

/// The mouse of the examples. With `keel`, two straight curves divide its flat side into four: one
/// loop without corners is embedded.
inline BuiltModel mouse(double edge_length, bool keel) {
  const Scene scene = read_scene(std::string(BATTEN_SOURCE_DIR) + "/examples/09-mouse/scene.toml");
  NetworkOptions how;
  how.corner_angle = 60;
  std::vector<CharacterLine> lines;
  for (const SceneLine& line : scene.lines)
    lines.push_back({line.name, curve_through_points(line.name, line.points, how.corner_angle)});
  RegionSearchOptions specs;
  if (keel) {
    lines.push_back(straight("keel", {0, -52.25, 0}, {0, 52.25, 0}));
    lines.push_back(straight("beam", {26.56, 0, 0}, {-23.91, 0, 0}));
  } else {
    specs.specs = scene.network.regions;
  }
  CurveNetwork network(lines, how);
  ModelOptions options;
  options.skin.edge_length = edge_length;
  options.joins = scene.network.joins;
  SurfaceModel model = skin_network(network, find_regions(network, specs), options);
  return {std::move(network), std::move(model)};
}

}  // namespace batten_test
