// Lines as the user gave them: CAD curves, sampled points, formulas.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "batten/fem/hermite_curve.h"

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
  /// Breaks at which the curve has a corner, however small its turn.
  virtual std::vector<double> corners() const { return {}; }
  /// True when every piece between breaks is a polynomial of degree 3 or less in t: such lines are
  /// reproduced exactly, not fitted.
  virtual bool piecewise_cubic() const { return false; }
};

/// A Hermite curve as an input curve.
std::shared_ptr<const InputCurve> curve_from_hermite(HermiteCurve curve);

/// A formula: X(t) and its derivatives up to order 2 for t in [start, end].
std::shared_ptr<const InputCurve> curve_from_formula(
    double start, double end, std::function<Vec3(double t, int order)> formula);

/// The cubic with Bézier control points p0 … p3, t in [0, 1].
std::shared_ptr<const InputCurve> bezier_curve(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                               const Vec3& p3);

}  // namespace batten
