// Arc length along an input curve.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "batten/fairing/input_curve.h"

namespace batten {

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
