// Arc length along an input curve.
#pragma once

#include <memory>
#include <vector>

#include "batten/fairing/input_curve.h"

namespace batten {

/// Arc length of an input curve, and its inverse: panels of Gauss points, 1e-12 on smooth curves.
class ArcLength {
 public:
  explicit ArcLength(std::shared_ptr<const InputCurve> curve);
  double total() const { return length_.back(); }
  /// Arc length from the start to the parameter t.
  double length_at(double t) const;
  /// Parameter t at arc length s from the start.
  double parameter(double s) const;

 private:
  std::shared_ptr<const InputCurve> curve_;
  std::vector<double> t_, length_;
};

}  // namespace batten
