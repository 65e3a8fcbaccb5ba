// Lines as the user gave them: CAD curves, sampled points, formulas.
#pragma once

#include <functional>
#include <memory>
#include <vector>
#include <Eigen/Core>

#include "batten/fem/curves/hermite_curve.h"

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


// Arc length along an input curve.

/// Arc length of an input curve, and its inverse: panels of Gauss points, 1e-12 on smooth curves.
class ArcLength {
 public:
  explicit ArcLength(std::shared_ptr<const InputCurve> curve);
  double total() const { return panels_.back().before + panels_.back().length; }
  /// Arc length from the start to the parameter t.
  double length_at(double t) const;
  /// Parameter t at arc length s from the start: of a panel's polynomial, then a Newton step or two.
  double parameter(double s) const;

 private:
  /// A stretch of the curve on which one Gauss rule tells the length.
  struct Panel {
    double start, end;                  ///< parameters
    double before, length;              ///< of the curve up to here, and of the panel
    Eigen::Matrix<double, 8, 1> speed;  ///< |dX/dt| at the Gauss points
  };
  const Panel& panel_at(double value, double Panel::*start) const;
  void add_panels(const Panel& whole, double total, int depth);

  std::shared_ptr<const InputCurve> curve_;
  std::vector<Panel> panels_;
};

}  // namespace batten
