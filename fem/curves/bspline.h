// SPDX-License-Identifier: MPL-2.0
// Cubic B-splines: their basis over given knots, and the exact conversion of curves.
#pragma once

#include <string>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Basis of cubic B-splines over simple knots. The basis is either clamped (end knots of
/// multiplicity four) or periodic.
class SplineAxis {
 public:
  SplineAxis() = default;
  /// `knots`: strictly increasing, two or more (at least one interval); for a periodic basis, five
  /// or more (at least four intervals).
  explicit SplineAxis(std::vector<double> knots, bool periodic = false);

  const std::vector<double>& knots() const { return knots_; }
  bool periodic() const { return periodic_; }
  int intervals() const { return isize(knots_) - 1; }
  /// Number of basis functions.
  int functions() const { return periodic_ ? intervals() : intervals() + 3; }
  double length(int interval) const { return knots_[interval + 1] - knots_[interval]; }
  /// Index of the knot interval that contains wrapped(t).
  int interval(double t) const;
  /// Parameter t mapped into the range of the knots: clamped or, if periodic, modulo the period.
  double wrapped(double t) const;
  /// Values of the four basis functions that are nonzero on a knot interval, at the local
  /// coordinate s in [0, 1] of the interval, or their derivatives of order `derivative` with
  /// respect to s.
  Eigen::Vector4d basis(int interval, double s, int derivative = 0) const;
  /// Index, among all basis functions, of one of the four that are nonzero on a knot interval.
  /// `local`: 0 to 3, in order along the knots.
  int function(int interval, int local) const {
    const int f = interval + local;
    return periodic_ && f >= intervals() ? f % intervals() : f;
  }

 private:
  std::vector<double> knots_;
  bool periodic_ = false;
  std::vector<Eigen::Matrix4d> powers_;  // per interval; row: power of s, column: function
};

// Exact conversion of Hermite curves to B-splines.

/// Clamped cubic B-spline. The first and last knots have multiplicity four. Inner knots are triple
/// at corners, double if the curve is only C1 there, and simple if it is C2 up to rounding (1e-13
/// of the size of the curve).
struct CubicSpline {
  std::string name;
  std::vector<double> knots;  ///< distinct knots, ascending, in the parameter u of the curve
  std::vector<int> multiplicities;
  std::vector<Vec3> poles;
  bool closed = false;  ///< true: closed curve, smooth where it returns to its first pole
  double size = 0;      ///< diagonal of the bounding box of the poles
};

/// Converts each smooth piece of a curve between two corners to a B-spline, in order along the
/// curve. A single spline is named `name`; several are named name.1, name.2, …. A closed curve with
/// corners begins at its first corner. Cost: O(segments).
std::vector<CubicSpline> cubic_splines(const std::string& name, const HermiteCurve& curve);

/// Converts a curve to a single B-spline over the same parameter range, whose inner knots are
/// triple at corners. Cost: O(segments).
CubicSpline whole_spline(const std::string& name, const HermiteCurve& curve);

}  // namespace batten
