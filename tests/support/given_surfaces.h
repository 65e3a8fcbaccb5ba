// SPDX-License-Identifier: MPL-2.0
// Surfaces with a formula as given neighbours: holes in them, with tangent planes and curvatures.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/LU>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/neighbour_edge.h"

namespace batten_test {

using namespace batten;

// A surface given by a formula of (u, v), |u|, |v| ≤ 1, and its distance from a point.
struct GivenSurface {
  std::function<Vec3(double u, double v)> x;
  std::function<double(const Vec3& p)> distance;
  Vec3 derivative(double u, double v, int du, int dv) const {
    constexpr double h = 1e-4;
    if (du + dv == 1) return (x(u + du * h, v + dv * h) - x(u - du * h, v - dv * h)) / (2 * h);
    if (du == 2) return (x(u + h, v) - 2 * x(u, v) + x(u - h, v)) / (h * h);
    if (dv == 2) return (x(u, v + h) - 2 * x(u, v) + x(u, v - h)) / (h * h);
    return (x(u + h, v + h) - x(u + h, v - h) - x(u - h, v + h) + x(u - h, v - h)) / (4 * h * h);
  }
};

inline GivenSurface given_sphere() {
  return {[](double u, double v) {
            const double r = std::hypot(u, v), c = r > 1e-12 ? std::sin(r) / r : 1;
            return Vec3(c * u, c * v, std::cos(r));
          },
          [](const Vec3& p) { return std::abs(p.norm() - 1); }};
}

inline GivenSurface given_cylinder() {
  return {[](double u, double v) { return Vec3(std::sin(u), v, std::cos(u)); },
          [](const Vec3& p) { return std::abs(std::hypot(p.x(), p.z()) - 1); }};
}

inline GivenSurface given_torus() {
  return {[](double u, double v) {
            const double r = 2 + 0.7 * std::cos(v / 0.7);
            return Vec3(r * std::sin(u / 2.7), 0.7 * std::sin(v / 0.7), r * std::cos(u / 2.7));
          },
          [](const Vec3& p) {
            return std::abs(std::hypot(std::hypot(p.x(), p.z()) - 2, p.y()) - 0.7);
          }};
}

inline GivenSurface given_waves() {
  return {[](double u, double v) {
            return Vec3(u, v, 0.1 * std::sin(3 * u) * std::cos(2.5 * v + 0.3));
          },
          {}};
}

// A hole with `sides` sides, straight in (u, v), and the surface beside it. One side is a circle,
// two sides are arcs.
struct Hole {
  std::vector<CharacterLine> lines;
  std::vector<NeighbourCurve> neighbours;
};

inline Hole hole_in(const GivenSurface& surface, int sides, double radius = 0.5) {
  Hole hole;
  const auto corner = [sides, radius](int k) {
    const double a = 2 * std::numbers::pi * k / sides + 0.3;
    return Vec2(radius * std::cos(a), radius * std::sin(a));
  };
  const auto at = [sides, radius, corner](int side, double f) -> Vec2 {
    if (sides == 1)
      return radius * Vec2(std::cos(2 * std::numbers::pi * f), std::sin(2 * std::numbers::pi * f));
    if (sides == 2) {  // two arcs of 108 degrees
      constexpr double half = 0.3 * std::numbers::pi;
      const double a = half * (1 - 2 * f), r = radius / std::sin(half);
      return (side == 0 ? 1 : -1) * r * Vec2(std::sin(a), std::cos(a) - std::cos(half));
    }
    return (1 - f) * corner(side) + f * corner(side + 1);
  };
  for (int side = 0; side < sides; ++side) {
    NeighbourCurve neighbour;
    neighbour.name = "surface";
    const int count = sides == 1 ? 1200 : 400;
    std::vector<Vec3> points;
    for (int i = 0; i <= count; ++i) {
      const double f = static_cast<double>(i) / count;
      const Vec2 p = sides == 1 && i == count ? at(0, 0) : at(side, f);
      const Vec2 before = at(side, f - 1e-5), after = at(side, f + 1e-5);
      const Vec3 along =
          (surface.x(after.x(), after.y()) - surface.x(before.x(), before.y())).normalized();
      Eigen::Matrix<double, 3, 2> X;
      X << surface.derivative(p.x(), p.y(), 1, 0), surface.derivative(p.x(), p.y(), 0, 1);
      const Vec3 n = X.col(0).cross(X.col(1)).normalized();
      const Vec3 into = along.cross(n).normalized();
      const Vec2 c = (X.transpose() * X).inverse() * (X.transpose() * into);
      const Vec3 second = c[0] * c[0] * surface.derivative(p.x(), p.y(), 2, 0) +
                          2 * c[0] * c[1] * surface.derivative(p.x(), p.y(), 1, 1) +
                          c[1] * c[1] * surface.derivative(p.x(), p.y(), 0, 2);
      neighbour.samples.push_back({surface.x(p.x(), p.y()), into, n.dot(second) * n});
      if (i % (count / 40) == 0) points.push_back(surface.x(p.x(), p.y()));
    }
    CharacterLine& line = hole.lines.emplace_back();
    line.name = "side" + std::to_string(side + 1);
    line.curve = sides == 1
                     ? curve_through_points(line.name, points)
                     : curve_from_formula(0, 1, [surface, at, side](double f, int order) -> Vec3 {
                         const auto x = [&](double s) {
                           const Vec2 p = at(side, s);
                           return surface.x(p.x(), p.y());
                         };
                         constexpr double h = 1e-4;
                         if (order == 0) return x(f);
                         if (order == 1) return (x(f + h) - x(f - h)) / (2 * h);
                         return (x(f + h) - 2 * x(f) + x(f - h)) / (h * h);
                       });
    hole.neighbours.push_back(std::move(neighbour));
  }
  return hole;
}

}  // namespace batten_test
