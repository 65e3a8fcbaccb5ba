// SPDX-License-Identifier: MPL-2.0
// Interface for curves given by the user (CAD curves, sampled points, formulas), and their arc
// length.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Interface of a parametric curve in space: continuous, and C1 between breaks(). Immutable.
class InputCurve {
 public:
  virtual ~InputCurve() = default;
  virtual double start() const = 0;
  virtual double end() const = 0;
  /// Position (order 0), first or second derivative at the curve parameter t. At one of the
  /// breaks(), derivatives are those of the piece that begins there; at end(), those of the last
  /// piece.
  virtual Vec3 evaluate(double t, int order = 0) const = 0;
  /// Parameters at which derivatives may jump, ascending, including start() and end().
  virtual std::vector<double> breaks() const { return {start(), end()}; }
  /// Those of the breaks() at which the curve has a corner, whatever its turning angle; start() if
  /// the curve is closed and has a corner there.
  virtual std::vector<double> corners() const { return {}; }
  /// True if every piece between breaks() is a polynomial of degree 3 or less in the parameter.
  /// Such curves are reproduced exactly instead of being fitted.
  virtual bool piecewise_cubic() const { return false; }
};

/// Wraps a Hermite curve as an input curve.
std::shared_ptr<const InputCurve> curve_from_hermite(HermiteCurve curve);

/// Makes an input curve from a formula for X(t) and its derivatives up to order 2, t in [start,
/// end].
std::shared_ptr<const InputCurve> curve_from_formula(
    double start, double end, std::function<Vec3(double t, int order)> formula);

/// Makes the cubic Bézier curve with control points p0 … p3, t in [0, 1].
std::shared_ptr<const InputCurve> bezier_curve(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                               const Vec3& p3);

/// Arc length of an input curve and its inverse, by adaptive Gauss quadrature; relative accuracy
/// 1e-12 on smooth curves, and not below 2e-15 of the distance from the origin.
class ArcLength {
 public:
  explicit ArcLength(std::shared_ptr<const InputCurve> curve);
  double total() const { return panels_.back().before + panels_.back().length; }
  /// Arc length of the curve from its start to the parameter t.
  double length_at(double t) const;
  /// Parameter of the curve at arc length s from its start, by inverting a polynomial approximation
  /// of the arc length and refining the result by Newton steps.
  double parameter(double s) const;

 private:
  /// Parameter interval over which one Gauss rule integrates the length.
  struct Panel {
    double start, end;                  ///< parameters
    double before, length;              ///< arc length up to the panel, and of the panel
    Eigen::Matrix<double, 8, 1> speed;  ///< |dX/dt| at the Gauss points
  };
  const Panel& panel_at(double value, double Panel::*start) const;
  void add_panels(const Panel& whole, double tolerance, int depth);

  std::shared_ptr<const InputCurve> curve_;
  std::vector<Panel> panels_;
};

}  // namespace batten
