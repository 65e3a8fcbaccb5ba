// Points in messages, and angles, said the same way everywhere.
#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {

/// The text "(x, y, z)" of a point; what is only rounding beside the largest coordinate is 0.
inline std::string format_point(const Vec3& p) {
  const double rounding = 1e-14 * p.cwiseAbs().maxCoeff();
  const auto word = [&](double x) { return format_number(std::abs(x) <= rounding ? 0.0 : x); };
  return "(" + word(p.x()) + ", " + word(p.y()) + ", " + word(p.z()) + ")";
}

/// Angle between two vectors of any length, degrees in [0, 180]; exact to rounding near 0 and 180.
inline double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

}  // namespace batten
