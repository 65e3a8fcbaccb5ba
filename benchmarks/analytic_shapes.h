// SPDX-License-Identifier: MPL-2.0
// Surfaces given by formulas, and curves on them, as exact references for surfaces built from the
// curves alone.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "batten/skinning/lines/character_line.h"

namespace batten::bench {

/// A number with its first two derivatives along a curve.
struct Jet {
  double x = 0, d = 0, dd = 0;
  Jet(double value = 0, double first = 0, double second = 0) : x(value), d(first), dd(second) {}
  friend Jet operator+(const Jet& a, const Jet& b) { return {a.x + b.x, a.d + b.d, a.dd + b.dd}; }
  friend Jet operator-(const Jet& a, const Jet& b) { return {a.x - b.x, a.d - b.d, a.dd - b.dd}; }
  friend Jet operator*(const Jet& a, const Jet& b) {
    return {a.x * b.x, a.d * b.x + a.x * b.d, a.dd * b.x + 2 * a.d * b.d + a.x * b.dd};
  }
  /// f(a) from f, f' and f''.
  static Jet chain(const Jet& a, double f, double f1, double f2) {
    return {f, f1 * a.d, f1 * a.dd + f2 * a.d * a.d};
  }
  friend Jet sin(const Jet& a) { return chain(a, std::sin(a.x), std::cos(a.x), -std::sin(a.x)); }
  friend Jet cos(const Jet& a) { return chain(a, std::cos(a.x), -std::sin(a.x), -std::cos(a.x)); }
  friend Jet inverse_root(const Jet& a) {
    const double r = 1 / std::sqrt(a.x);
    return chain(a, r, -0.5 * r / a.x, 0.75 * r / (a.x * a.x));
  }
};

/// x(s, t), regular on the unit square and slightly beyond.
struct Formula {
  using Space = std::array<Jet, 3>;
  using At = std::function<Space(const Jet& s, const Jet& t)>;
  At at;
  Formula(At formula) : at(std::move(formula)) {}

  Vec3 operator()(double s, double t) const { return of(at(s, t), 0); }
  Vec3 along_s(double s, double t) const { return of(at(Jet(s, 1), t), 1); }
  Vec3 along_t(double s, double t) const { return of(at(s, Jet(t, 1)), 1); }

  struct FootPoint {
    double distance = 0;
    Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
  };
  /// The closest point: samples, then Gauss-Newton and Newton steps.
  FootPoint closest(const Vec3& p) const {
    constexpr int n = 24;
    if (starts_.empty())
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
          starts_.push_back({1.0 * i / n, 1.0 * j / n, (*this)(1.0 * i / n, 1.0 * j / n)});
    const Start* best = &starts_[0];
    for (const Start& start : starts_)
      if ((start.x - p).squaredNorm() < (best->x - p).squaredNorm()) best = &start;
    double s = best->s, t = best->t;
    for (int step = 0; step < 30; ++step) {
      const Vec3 away = p - (*this)(s, t), a = along_s(s, t), b = along_t(s, t);
      const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), det = aa * bb - ab * ab;
      const double ds = (bb * away.dot(a) - ab * away.dot(b)) / det,
                   dt = (aa * away.dot(b) - ab * away.dot(a)) / det;
      s += ds;
      t += dt;
      if (std::abs(ds) + std::abs(dt) < 1e-13) break;
    }
    const Vec3 at = (*this)(s, t);
    return {(at - p).norm(), at, along_s(s, t).cross(along_t(s, t)).normalized()};
  }

  static Vec3 of(const Space& x, int order) {
    Vec3 v;
    for (int i = 0; i < 3; ++i)
      v[i] = order == 0   ? x[static_cast<size_t>(i)].x
             : order == 1 ? x[static_cast<size_t>(i)].d
                          : x[static_cast<size_t>(i)].dd;
    return v;
  }

 private:
  struct Start {
    double s, t;
    Vec3 x;
  };
  mutable std::vector<Start> starts_;
};

/// The curve x(s(q), t(q)) for q from 0 to 1.
inline CharacterLine line_on(const std::string& name, const Formula& f,
                             const std::function<std::array<Jet, 2>(const Jet& q)>& path,
                             CharacterLine::Role role) {
  return {name,
          curve_from_formula(0, 1,
                             [at = f.at, path](double q, int order) -> Vec3 {
                               const auto st = path(Jet(q, 1));
                               return Formula::of(at(st[0], st[1]), order);
                             }),
          role};
}

struct AnalyticShape {
  std::string name;
  Formula surface;
  enum class Domain { Square, Triangle, Annulus } domain = Domain::Square;
  double coarse = 0.25;  ///< edge length of the first grid

  std::vector<CharacterLine> boundary() const {
    using Path = std::function<std::array<Jet, 2>(const Jet&)>;
    std::vector<Path> paths;
    if (domain == Domain::Square)
      paths = {[](const Jet& q) {
                 return std::array<Jet, 2>{q, 0};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{1, q};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{Jet(1) - q, 1};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{0, Jet(1) - q};
               }};
    else if (domain == Domain::Triangle)
      paths = {[](const Jet& q) {
                 return std::array<Jet, 2>{q, 0};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{Jet(1) - q, q};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{0, Jet(1) - q};
               }};
    else
      paths = {[](const Jet& q) {
                 return std::array<Jet, 2>{q, 0};
               },
               [](const Jet& q) {
                 return std::array<Jet, 2>{q, 1};
               }};
    std::vector<CharacterLine> lines;
    for (const Path& path : paths)
      lines.push_back(line_on("side " + std::to_string(lines.size() + 1), surface, path,
                              CharacterLine::Role::Outline));
    return lines;
  }
  /// n slightly wavy curves along s that end shortly before the boundary.
  std::vector<CharacterLine> inner(int n) const {
    std::vector<CharacterLine> lines;
    for (int k = 1; k <= n; ++k) {
      const double row = 1.0 * k / (n + 1);
      const bool triangle = domain == Domain::Triangle;
      lines.push_back(line_on(
          "inner " + std::to_string(k), surface,
          [row, triangle](const Jet& q) {
            const Jet s = Jet(0.01) + Jet(0.98) * q,
                      t = Jet(row) + Jet(0.02) * sin(Jet(2 * std::numbers::pi) * q);
            if (!triangle) return std::array<Jet, 2>{s, t};
            const Jet b = Jet(0.85) * t;
            return std::array<Jet, 2>{s * (Jet(1) - b), b};
          },
          CharacterLine::Role::Inner));
    }
    return lines;
  }
};

inline std::vector<AnalyticShape> analytic_shapes() {
  constexpr double pi = std::numbers::pi;
  using Space = Formula::Space;
  using Domain = AnalyticShape::Domain;
  std::vector<AnalyticShape> all;
  for (const int degrees : {90, 170, 200, 270, 350}) {
    const double angle = degrees * pi / 180;
    all.push_back({"cylinder " + std::to_string(degrees), {[angle](const Jet& s, const Jet& t) {
                     const Jet a = Jet(angle) * (s - Jet(0.5));
                     return Space{cos(a), sin(a), t};
                   }}});
  }
  const auto rings = [](double low, double high, double height) {
    return Formula([=](const Jet& s, const Jet& t) {
      const Jet a = Jet(2 * pi) * s, r = Jet(low) + Jet(high - low) * t;
      return Space{r * cos(a), r * sin(a), Jet(height) * t};
    });
  };
  all.push_back({"rings, equal", rings(1, 1, 1.2), Domain::Annulus});
  all.push_back({"rings, unequal", rings(1, 0.6, 1), Domain::Annulus});
  all.push_back({"sphere octant", Formula([](const Jet& s, const Jet& t) {
                   const Jet a = Jet(1) - s - t;
                   const Jet r = inverse_root(a * a + s * s + t * t);
                   return Space{a * r, s * r, t * r};
                 }),
                 Domain::Triangle});
  all.push_back({"saddle", Formula([](const Jet& s, const Jet& t) {
                   const Jet x = Jet(2) * s - Jet(1), y = Jet(2) * t - Jet(1);
                   return Space{x, y, Jet(0.5) * (x * x - y * y)};
                 })});
  all.push_back({"helicoid strip", Formula([](const Jet& s, const Jet& t) {
                   const Jet a = Jet(pi) * s, r = Jet(0.5) + t;
                   return Space{r * cos(a), r * sin(a), Jet(0.4) * a};
                 })});
  all.push_back({"torus quarter", Formula([](const Jet& s, const Jet& t) {
                   const Jet a = Jet(0.5 * pi) * s, b = Jet(pi) * (t - Jet(0.5));
                   const Jet r = Jet(2) + Jet(0.7) * cos(b);
                   return Space{r * cos(a), r * sin(a), Jet(0.7) * sin(b)};
                 })});
  return all;
}

}  // namespace batten::bench
