// Regions of the (u, v) plane bounded by loops of cubic curves.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

// Planar cubic arcs, and their intersections with straight lines.

/// Cubic c(t), t in [0, 1], in the plane, by its Bézier points.
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
  /// Subarc from t0 to t1, reparametrised to [0, 1]; its ends are at(t0) and at(t1).
  PlanarCubic part(double t0, double t1) const {
    const double h = (t1 - t0) / 3;
    const Vec2 p = at(t0), q = at(t1);
    return {{p, p + h * slope(t0), q - h * slope(t1), q}};
  }
};

/// Cubic polynomial in one variable on [0, 1], by its Bernstein coefficients.
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
  /// Breakpoints of monotone intervals: 0, the extrema inside (0, 1), and 1.
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
  /// Zero in a monotone interval whose ends have different signs, by Newton's method with
  /// bisection.
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

/// The arcs of a curve in the plane z = 0, one per segment.
class HermiteCurve;
std::vector<PlanarCubic> planar_cubics(const HermiteCurve& curve);

/// Region to the left of closed loops: an outer loop runs counter-clockwise, a hole clockwise.
/// Loops must not intersect. Immutable.
///
/// A loop is one closed HermiteCurve with z = 0, or several open ones joined end to end.
class DomainLoops {
 public:
  using Loop = std::vector<HermiteCurve>;
  /// Side of points far away: Outside of the region, or Inside (there are only holes, and the
  /// region is bounded by something else).
  enum class Background { Outside, Inside };

  /// Region without loops: the whole plane, or nothing.
  explicit DomainLoops(Background background = Background::Inside)
      : background_(background), box_(Vec2(0, 0)) {}
  /// Throws InputError if a curve leaves the plane z = 0, if consecutive curves of a loop do not
  /// meet (within 1e-9 of the bounding box of all loops), or if a loop is empty.
  explicit DomainLoops(std::vector<Loop> loops, Background background = Background::Outside);

  const std::vector<Loop>& loops() const { return loops_; }
  /// All arcs, loop after loop; the common ends of arcs are bit-identical.
  const std::vector<PlanarCubic>& segments() const { return segments_; }
  Background background() const { return background_; }

  /// Whether p is inside, by the winding number of a ray intersected with the cubics themselves:
  /// exact to rounding. For points on a curve, either result is possible. Cost:
  /// O(arcs at the v of p).
  bool contains(const Vec2& p) const;
  /// Enclosed area; with Background::Inside, minus the area of the holes. Exact.
  double area() const;
  Vec2 low() const { return box_.min(); }
  Vec2 high() const { return box_.max(); }

 private:
  // Part of an arc on which v is monotone.
  struct Monotone {
    int segment;
    double t0, t1, v0, v1, u_low, u_high;
  };
  void sort_into_bands();
  size_t band(double v) const;  // monotone in v
  Background background_;
  std::vector<Loop> loops_;
  std::vector<PlanarCubic> segments_;
  std::vector<Monotone> monotone_;
  // Indices of the parts that intersect each band of v, from bands_[i] to bands_[i + 1].
  std::vector<int> in_bands_;
  std::vector<size_t> bands_ = {0, 0};
  Box2 box_;
};

}  // namespace batten
