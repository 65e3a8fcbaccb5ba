// Cubic B-spline basis in one variable.
#pragma once

#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"

namespace batten {

/// Basis of cubic B-splines over simple knots. The end knots have multiplicity four (clamped), or
/// the basis is periodic.
class SplineAxis {
 public:
  SplineAxis() = default;
  /// `knots`: increasing, at least two (one interval); periodic: at least four intervals.
  explicit SplineAxis(std::vector<double> knots, bool periodic = false);

  const std::vector<double>& knots() const { return knots_; }
  bool periodic() const { return periodic_; }
  int intervals() const { return isize(knots_) - 1; }
  /// Number of basis functions.
  int functions() const { return periodic_ ? intervals() : intervals() + 3; }
  double length(int interval) const { return knots_[interval + 1] - knots_[interval]; }
  /// Interval that contains t, and t mapped into the knot range: clamped, or wrapped if periodic.
  int interval(double t) const;
  double wrapped(double t) const;
  /// The four basis functions that are nonzero on an interval, at s in [0, 1], or their derivatives
  /// with respect to s.
  Eigen::Vector4d basis(int interval, double s, int derivative = 0) const;
  /// Global index of the basis function `local` (0 to 3) of an interval.
  int function(int interval, int local) const {
    const int f = interval + local;
    return periodic_ && f >= intervals() ? f % intervals() : f;
  }

 private:
  std::vector<double> knots_;
  bool periodic_ = false;
  std::vector<Eigen::Matrix4d> powers_;  // per interval; row: power of s, column: function
};

}  // namespace batten
