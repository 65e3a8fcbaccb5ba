// Cubic B-splines of one variable. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/containers.h"

namespace batten {

/// Cubic B-splines of one variable over simple knots: at the ends of the line the knots count four
/// times, or the line closes.
class SplineAxis {
 public:
  SplineAxis() = default;
  /// At least one interval, periodic: four. Increasing.
  explicit SplineAxis(std::vector<double> knots, bool periodic = false);

  const std::vector<double>& knots() const { return knots_; }
  bool periodic() const { return periodic_; }
  int intervals() const { return isize(knots_) - 1; }
  int functions() const { return periodic_ ? intervals() : intervals() + 3; }
  double length(int interval) const { return knots_[interval + 1] - knots_[interval]; }
  /// t is clamped, or comes around.
  int interval(double t) const;
  double wrapped(double t) const;
  /// The four functions that live on an interval at s in [0, 1], or their derivatives by s.
  Eigen::Vector4d basis(int interval, double s, int derivative = 0) const;
  /// Number of the local-th of them.
  int function(int interval, int local) const {
    const int f = interval + local;
    return periodic_ && f >= intervals() ? f % intervals() : f;
  }

 private:
  std::vector<double> knots_;
  bool periodic_ = false;
  std::vector<Eigen::Matrix4d> powers_;  // of each interval; row: power of s, column: function
};

}  // namespace batten
