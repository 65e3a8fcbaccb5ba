// Lines as the user gave them: CAD curves, sampled points, formulas.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "batten/fem/curve.h"

namespace batten {

/// A curve in space over one parameter interval, continuous, C1 between breaks(). Immutable.
class InputCurve {
 public:
  virtual ~InputCurve() = default;
  virtual double start() const = 0;
  virtual double end() const = 0;
  /// Position (order 0), first or second derivative with respect to t. At a break, derivatives are
  /// those of the piece after it (of the last piece at end()).
  virtual Vec3 evaluate(double t, int order = 0) const = 0;
  /// Parameters where derivatives may jump, start() and end() included, increasing.
  virtual std::vector<double> breaks() const { return {start(), end()}; }
  /// True when every piece between breaks is a polynomial of degree 3 or less in t: such lines are
  /// reproduced exactly, not fitted.
  virtual bool piecewise_cubic() const { return false; }
};

/// A curve through points, in their order. Between corners (where the direction turns by more than
/// `corner_angle` degrees at a point) it is the C2 cubic spline through the points over their chord
/// lengths, whose first and last pieces are parabolas; three points give a parabola, two a straight
/// line. A point list whose last point
/// equals its first is closed: C2 across the seam too, unless it turns a corner there. Throws
/// InputError: fewer than two points, a number that is not finite, two successive points that
/// coincide (closer than 1e-9 of the size), all points in one place. `name` is used in messages.
std::shared_ptr<const InputCurve> curve_through_points(const std::string& name,
                                                       const std::vector<Vec3>& points,
                                                       double corner_angle = 20);

/// A Hermite curve as an input curve.
std::shared_ptr<const InputCurve> curve_from_hermite(HermiteCurve curve);

/// A formula: X(t) and its derivatives up to order 2 for t in [start, end].
std::shared_ptr<const InputCurve> curve_from_formula(
    double start, double end, std::function<Vec3(double t, int order)> formula);

/// The cubic with Bézier control points p0 … p3, t in [0, 1].
std::shared_ptr<const InputCurve> bezier_curve(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                               const Vec3& p3);

}  // namespace batten
