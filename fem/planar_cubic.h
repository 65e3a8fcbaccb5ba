// One cubic arc in the (u, v) plane, and where it meets a straight line.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A cubic c(t), t in [0, 1], by its Bézier points.
struct PlanarCubic {
  std::array<Vec2, 4> b;

  Vec2 at(double t) const {
    const double s = 1 - t;
    return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
  }
  Vec2 slope(double t) const {
    const double s = 1 - t;
    return 3 * (s * s * (b[1] - b[0]) + 2 * s * t * (b[2] - b[1]) + t * t * (b[3] - b[2]));
  }
  /// The part from t0 to t1 as an arc of its own; its ends are at(t0) and at(t1).
  PlanarCubic part(double t0, double t1) const {
    const double h = (t1 - t0) / 3;
    const Vec2 p = at(t0), q = at(t1);
    return {{p, p + h * slope(t0), q - h * slope(t1), q}};
  }
};

/// A cubic in one variable by its Bernstein coefficients.
struct BernsteinCubic {
  std::array<double, 4> b;

  double at(double t) const {
    const double s = 1 - t;
    return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
  }
  double slope(double t) const {
    const double s = 1 - t;
    return 3 * (s * s * (b[1] - b[0]) + 2 * s * t * (b[2] - b[1]) + t * t * (b[3] - b[2]));
  }
  /// 0, the turning points inside (0, 1), 1: monotone between neighbours.
  std::vector<double> monotone_parts() const {
    std::vector<double> t{0};
    const double d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
    const double a = d0 - 2 * d1 + d2, half = d1 - d0;  // a t² + 2 half t + d0 = 0
    const double disc = half * half - a * d0;
    if (disc > 0) {
      const double q = -(half + std::copysign(std::sqrt(disc), half));
      for (const double x : {q / a, d0 / q})
        if (x > 0 && x < 1) t.push_back(x);
      std::sort(t.begin(), t.end());
    }
    t.push_back(1);
    return t;
  }
  /// The zero of a monotone part whose ends have different signs: Newton's method between bounds.
  double zero(double low, double high) const {
    const bool rises = at(high) > at(low);
    double t = 0.5 * (low + high);
    for (int step = 0; step < 100; ++step) {
      const double f = at(t);
      if (f == 0) return t;
      ((f > 0) == rises ? high : low) = t;
      double next = t - f / slope(t);
      if (!(next > low && next < high)) next = 0.5 * (low + high);
      if (std::abs(next - t) <= 1e-16 || next == t) return next;
      t = next;
    }
    return t;
  }
  /// All zeros in [0, 1] where the sign changes, ascending.
  std::vector<double> zeros() const {
    std::vector<double> found;
    const auto parts = monotone_parts();
    for (size_t i = 0; i + 1 < parts.size(); ++i) {
      const double f0 = at(parts[i]), f1 = at(parts[i + 1]);
      if ((f0 < 0) != (f1 < 0)) found.push_back(zero(parts[i], parts[i + 1]));
    }
    return found;
  }
};

/// The arcs of a curve in the plane (z = 0), one for each of its segments.
class HermiteCurve;
std::vector<PlanarCubic> planar_cubics(const HermiteCurve& curve);

}  // namespace batten
