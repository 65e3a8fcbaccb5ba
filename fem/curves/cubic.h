// SPDX-License-Identifier: MPL-2.0
// Cubic polynomials in one variable: their forms, their zeros, and curves that consist of them.
//
//     Bézier     c(t) = (1-t)³ b0 + 3 (1-t)² t b1 + 3 (1-t) t² b2 + t³ b3        BezierCubic
//     powers     c(t) = c0 + c1 t + c2 t² + c3 t³                                PowerCubic
//     Hermite    c(0), c'(0), c(1), c'(1)                                        HermiteSegment
//
//     b1 = b0 + c'(0)/3,  b2 = b3 - c'(1)/3
//     c1 = c'(0),  c2 = 3 (c(1) - c(0)) - 2 c'(0) - c'(1),  c3 = 2 (c(0) - c(1)) + c'(0) + c'(1)
//
// The variable t runs over [0, 1]. On an interval of length h, derivatives with respect to the
// parameter of the interval are the derivatives with respect to t, divided by h. The Bézier points
// of a real-valued cubic are its Bernstein coefficients. For B-splines see bspline.h. Reference:
// [Farin2002], chapters 4 to 7.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

// One cubic.

/// Cubic polynomial in t, 0 ≤ t ≤ 1, in Bézier form. `Point`: double, Vec2 or Vec3. BezierCubic is
/// an aggregate, so the Bézier points can be listed in braces.
template <class Point>
struct BezierCubic {
  std::array<Point, 4> b;  ///< Bézier points b0 … b3

  /// Cubic from p to q with the first derivatives 3 · `first_third` at p, 3 · `last_third` at q.
  static BezierCubic between(const Point& p, const Point& first_third, const Point& last_third,
                             const Point& q) {
    return {{p, p + first_third, q - last_third, q}};
  }
  /// Straight line from p to q with constant speed.
  static BezierCubic straight(const Point& p, const Point& q) {
    const Point third = (q - p) / 3;
    return between(p, third, third, q);
  }

  Point at(double t) const {
    const double s = 1 - t;
    return s * s * s * b[0] + 3 * s * s * t * b[1] + 3 * s * t * t * b[2] + t * t * t * b[3];
  }
  /// First derivative with respect to t.
  Point slope(double t) const {
    const double s = 1 - t;
    return 3 * (s * s * (b[1] - b[0]) + 2 * s * t * (b[2] - b[1]) + t * t * (b[3] - b[2]));
  }
  /// Second derivative with respect to t.
  Point second(double t) const {
    const double s = 1 - t;
    return 6 * (s * (b[2] - 2 * b[1] + b[0]) + t * (b[3] - 2 * b[2] + b[1]));
  }
  /// Part of the cubic from t0 to t1, reparametrised to [0, 1]. The end points are bit-identical to
  /// at(t0) and at(t1).
  BezierCubic part(double t0, double t1) const {
    const double h = (t1 - t0) / 3;
    const Point p = at(t0), q = at(t1);
    return between(p, h * slope(t0), h * slope(t1), q);
  }
  /// Blossom (polar form) of the cubic: the symmetric function, affine in each of its three
  /// variables, that equals the cubic if all three variables are equal. Evaluated by de Casteljau's
  /// algorithm. The Bézier points of the part from t0 to t1 are the values at (t0, t0, t0), (t0,
  /// t0, t1), (t0, t1, t1) and (t1, t1, t1); the poles of a B-spline are the values at three
  /// consecutive knots.
  Point blossom(double t0, double t1, double t2) const {
    std::array<Point, 4> p = b;
    const std::array<double, 3> at = {t0, t1, t2};
    for (size_t level = 0; level < 3; ++level)
      for (size_t i = 0; i + level < 3; ++i) p[i] = (1 - at[level]) * p[i] + at[level] * p[i + 1];
    return p[0];
  }
};

using PlanarCubic = BezierCubic<Vec2>;

/// Real-valued cubic polynomial in t, 0 ≤ t ≤ 1, in Bézier form, and its zeros.
struct BernsteinCubic : BezierCubic<double> {
  /// Cubic that is one coordinate (`axis`: 0 for x, 1 for y) of a planar cubic, minus `origin`.
  static BernsteinCubic coordinate(const PlanarCubic& cubic, int axis, double origin = 0) {
    return {{{cubic.b[0][axis] - origin, cubic.b[1][axis] - origin, cubic.b[2][axis] - origin,
              cubic.b[3][axis] - origin}}};
  }
  /// Ascending parameters between which the cubic is monotone: 0, its extrema in (0, 1), and 1.
  std::vector<double> monotone_parts() const;
  /// Parameter between `low` and `high` at which the cubic is zero, by Newton's method safeguarded
  /// by bisection. The cubic must be monotone from `low` to `high` and change sign in between.
  double zero(double low, double high) const;
  /// All parameters in [0, 1] at which the cubic changes sign, ascending.
  std::vector<double> zeros() const;
};

/// Cubic polynomial c0 + c1 t + c2 t² + c3 t³, which takes fewer operations than the Bézier form.
template <class Point>
struct PowerCubic {
  Point c0, c1, c2, c3;

  static PowerCubic of_bezier(const BezierCubic<Point>& cubic) {
    const auto& b = cubic.b;
    return {b[0], 3 * (b[1] - b[0]), 3 * (b[2] - 2 * b[1] + b[0]),
            b[3] - 3 * b[2] + 3 * b[1] - b[0]};
  }
  /// Cubic from p (t = 0) to q (t = 1) with the derivatives `slope_p` and `slope_q` at these ends.
  static PowerCubic of_hermite(const Point& p, const Point& slope_p, const Point& q,
                               const Point& slope_q) {
    return {p, slope_p, 3 * (q - p) - 2 * slope_p - slope_q, 2 * (p - q) + slope_p + slope_q};
  }

  Point at(double t) const { return c0 + t * (c1 + t * (c2 + t * c3)); }
  /// First derivative with respect to t.
  Point slope(double t) const { return c1 + t * (2 * c2 + 3 * t * c3); }
  /// Second derivative with respect to t.
  Point second(double t) const { return 2 * c2 + 6 * t * c3; }
};

/// Value of the cubic that has the values p, q and the derivatives `slope_p`, `slope_q` at the two
/// ends of an interval of length h. `t`: position in the interval, 0 to 1; derivatives are with
/// respect to h t. If p = q and the derivatives vanish, the value is exactly p. `Point`: a vector.
template <class Point>
Point hermite_value(const Point& p, const Point& slope_p, const Point& q, const Point& slope_q,
                    double h, double t) {
  const double s = 1 - t;
  return p + t * t * (3 - 2 * t) * (q - p) + h * t * s * (s * slope_p - t * slope_q);
}

/// Smoothstep cubic 3t² - 2t³, which rises from 0 at t = 0 to 1 at t = 1 with slope 0 at both ends.
inline double smooth_step(double t) { return t * t * (3 - 2 * t); }

// Cubics through given values.

/// Condition that an interpolating cubic spline satisfies at one of its ends.
enum class SplineEnd {
  Natural,    ///< the second derivative vanishes at this end
  Parabolic,  ///< the last piece at this end is a parabola (constant second derivative)
  Given       ///< the caller prescribes the slope at this end
};

/// Computes the slopes, one row per knot, of the C2 cubic spline that interpolates the values at
/// the knots.
///
/// `knots`: n ≥ 2, strictly ascending. `values`, `slopes`: n×3; the slope at an end of type
/// SplineEnd::Given is read, all others are written. Two points with parabolic ends are joined by a
/// straight line. Cost: O(n). Reference: [deBoor2001], chapter IV.
void spline_slopes(std::span<const double> knots, const Eigen::Ref<const Points>& values,
                   SplineEnd first, SplineEnd last, Eigen::Ref<Points> slopes);

/// A C1 piecewise cubic curve, given by values and slopes at ascending knots. It is extended
/// linearly beyond its ends. Use HermiteCurve for curves whose dofs are the unknowns of a system.
class PiecewiseCubic {
 public:
  PiecewiseCubic() = default;
  /// Curve with given values and first derivatives (`slopes`), one row of each per knot.
  PiecewiseCubic(std::vector<double> knots, Points values, Points slopes)
      : knots_(std::move(knots)), values_(std::move(values)), slopes_(std::move(slopes)) {}

  /// Condition at both ends of a curve made by through().
  enum class Ends {
    Natural,  ///< zero second derivative at both ends
    Flat      ///< zero slope at both ends
  };
  /// C2 cubic spline x(u) through one value per knot, which minimises ∫ |x''|² du. `knots`:
  /// strictly ascending. `values`: one row per knot. Cost: O(knots).
  static PiecewiseCubic through(std::vector<double> knots, const Points& values, Ends ends);
  /// Least-squares fit by uniform cubic B-splines: the C2 curve with `spans` uniform spans over the
  /// range of `u` that is nearest to `values`, one row per parameter in `u`. `u`: ascending, not
  /// constant, at least spans + 3 entries and at least one entry per span. Cost: O(values + spans).
  static PiecewiseCubic fitted(const std::vector<double>& u, const Points& values, int spans);

  const std::vector<double>& knots() const { return knots_; }
  /// Value of the curve at parameter u.
  Vec3 at(double u) const;
  /// First derivative of the curve at parameter u.
  Vec3 slope(double u) const;

 private:
  int piece(double u) const;
  std::vector<double> knots_;
  Points values_, slopes_;
};

}  // namespace batten
