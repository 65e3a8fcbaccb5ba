// SPDX-License-Identifier: MPL-2.0
// Random outlines with holes and inner curves: smooth, with corners, thin, nearly touching,
// self-intersecting, wrongly nested.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "batten/core/errors.h"
#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

using Role = CharacterLine::Role;

/// The same numbers give the same curves on every machine.
inline std::vector<CharacterLine> random_lines(Random& random) {
  constexpr double pi = std::numbers::pi;
  const double a = 1, b = random.between(0, 1) < 0.15 ? 0.04 : random.between(0.4, 1.2);
  struct Wave {
    double amplitude, phase;
    int n;
  };
  const auto waves = [&](double size) {
    std::vector<Wave> all;
    for (int n = 2; n <= 5; ++n) all.push_back({size * random() / n, pi * random(), n});
    return all;
  };
  const auto sum = [](const std::vector<Wave>& all, double t) {
    double s = 0;
    for (const Wave& w : all) s += w.amplitude * std::cos(w.n * t + w.phase);
    return s;
  };
  const auto height_waves = waves(0.2);
  const double crown = 0.4 * random();
  const auto height = [=](double x, double y) {
    return crown * (x * x + y * y) + sum(height_waves, 1.7 * x + 0.9 * y);
  };
  const auto loop = [&](const std::string& name, Role role, Vec2 centre, double rx, double ry,
                        const std::vector<Wave>& shape, int points, bool cornered) {
    std::vector<Vec3> p;
    for (int i = 0; i < points; ++i) {
      const double t = 2 * pi * i / points, r = 1 + sum(shape, t);
      const double x = centre.x() + rx * r * std::cos(t), y = centre.y() + ry * r * std::sin(t);
      p.emplace_back(x, y, height(x, y));
    }
    p.push_back(p.front());
    return CharacterLine{name, curve_through_points(name, p, cornered ? 20 : 170), role};
  };

  std::vector<CharacterLine> lines;
  const bool cornered = random.between(0, 1) < 0.4;
  // Amplitudes up to 1.2 lead to self-intersecting loops.
  const double roughness = random.between(0, 1) < 0.15 ? 1.2 : random.between(0, 0.5);
  lines.push_back(loop("outline", Role::Outline, {0, 0}, a, b, waves(roughness),
                       cornered ? 3 + static_cast<int>(random.between(0, 6)) : 48, cornered));
  const int holes = static_cast<int>(random.between(0, 3.2));
  for (int h = 0; h < holes; ++h) {
    const double r = std::exp(random.between(std::log(0.02), std::log(0.2)));
    const Vec2 centre(0.5 * random() * a, 0.5 * random() * b);
    lines.push_back(loop("hole " + std::to_string(h + 1), Role::Hole, centre, r,
                         r * random.between(0.4, 1) * std::min(1.0, 2 * b), waves(0.2), 24, false));
  }
  const int ribs = static_cast<int>(random.between(0, 3));
  for (int k = 0; k < ribs; ++k) {
    std::vector<Vec3> p;
    Vec2 at(0.4 * random() * a, 0.4 * random() * b);
    double direction = pi * random();
    const double turning_angle = 0.25 * random(),
                 step = random.between(0.02, 0.1) * std::min(1.0, 3 * b);
    // Most are on the same smooth sheet; some are not, and cannot intersect the others.
    const double above = random.between(0, 1) < 0.3 ? 0.05 * random() : 0;
    for (int i = 0; i < 9; ++i) {
      p.emplace_back(at.x(), at.y(), height(at.x(), at.y()) + above);
      at += step * Vec2(std::cos(direction), std::sin(direction));
      direction += turning_angle;
    }
    const std::string name = "rib " + std::to_string(k + 1);
    lines.push_back({name, curve_through_points(name, p), Role::Inner});
  }
  return lines;
}

struct RandomResult {
  std::string error_message;  ///< message of the program; "": there is a surface
  std::string kind;           ///< short reason of the rejection
  double reported = 0, found = 0, tolerance = 0;
  bool finite = true;
  int triangles = 0;
};

/// The reason without names and numbers, for counting equal ones.
inline std::string error_kind(const Error& e) {
  const std::string text = e.what();
  if (dynamic_cast<const ConflictError*>(&e)) return "constraints contradict each other";
  if (dynamic_cast<const NoSolutionError*>(&e)) return "no solution: " + text.substr(0, 40);
  for (const char* words : {"does not bound the face", "leaves the face", "apart in space",
                            "cannot be projected", "cannot be meshed", "touch", "intersect",
                            "closed loop", "on one straight line", "twice", "beyond curve"})
    if (text.find(words) != std::string::npos) return words;
  return text;
}

/// Skins the curves, and measures the distance from each curve at 997 independent points.
inline RandomResult skin_at_random(const std::vector<CharacterLine>& lines) {
  RandomResult result;
  SkinOptions options;
  options.tolerance = 2e-3;
  options.edge_length = 0.15;
  try {
    const RegionLayout layout("random", lines, options);
    const SkinnedRegion region = layout.region(ModelLayout(layout).minimize_energy({}));
    result.tolerance = layout.tolerance();
    result.finite = region.surface.dofs().allFinite();
    result.triangles = layout.mesh()->triangle_count();
    const TriangleLocator locator(region.surface.mesh());
    for (const EmbeddedLine& line : region.embedded) {
      result.reported = std::max(result.reported, line_gap(region.surface, line));
      for (int i = 0; i < 997; ++i) {
        const double t =
            line.pcurve.start() + (line.pcurve.end() - line.pcurve.start()) * (i + 0.5) / 997;
        const Vec3 c = line.pcurve.evaluate(t);
        const Vec3 x = region.surface.position(locator.locate({c.x(), c.y()}));
        result.found = std::max(result.found, (x - line.fitted.evaluate(t)).norm());
      }
    }
  } catch (const Error& e) {
    result.error_message = e.what();
    result.kind = error_kind(e);
  }
  return result;
}

}  // namespace batten_test
