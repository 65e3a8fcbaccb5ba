// Hermite curves as B-splines, without a change of shape.
#pragma once

#include <string>
#include <vector>

#include "batten/fem/hermite_curve.h"

namespace batten {

/// A clamped cubic B-spline: `knots` increase, the first and the last four times, an inner one
/// twice where the curve is C1 only, once where it is C2 to rounding (1e-13 of its size).
struct CubicSpline {
  std::string name;
  std::vector<double> knots;  ///< the curve's own u
  std::vector<int> multiplicities;
  std::vector<Vec3> poles;
  bool closed = false;  ///< comes back to its first pole, smoothly
  double size = 0;      ///< diagonal of the box around its poles
};

/// Each stretch between corners, in their order along the curve; named `name`, or name.1, name.2,
/// … when there are several. A closed curve with corners begins at its first corner. O(segments).
std::vector<CubicSpline> cubic_splines(const std::string& name, const HermiteCurve& curve);

}  // namespace batten
