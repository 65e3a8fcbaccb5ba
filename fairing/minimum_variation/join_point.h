// Points of lines at which two parts of a surface join smoothly.
#pragma once

#include <array>

#include "batten/core/eigen.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Two places of a surface that are one point of a line at which two of its parts, meshed apart,
/// join smoothly.
struct JoinPoint {
  std::array<Location, 2> at;
  /// The line's slope in the (u, v) of each part, per unit of one parameter for both.
  std::array<Vec2, 2> direction;
  double weight = 0;      ///< of this point in an integral over that parameter
  bool curvature = true;  ///< whether the jump of curvature counts
  bool tangent = true;    ///< whether that of the tangent plane does; not where constraints hold it
};

}  // namespace batten
