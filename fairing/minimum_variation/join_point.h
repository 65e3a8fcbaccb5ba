// Sample points on lines along which two separately meshed parts of a surface join smoothly.
#pragma once

#include <array>

#include "batten/core/eigen.h"
#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Two parametric locations that represent the same point of a line along which two separately
/// meshed parts of a surface join smoothly.
struct JoinPoint {
  std::array<Location, 2> at;
  /// Direction of the line in the (u, v) of each part: its derivative with respect to one line
  /// parameter common to both.
  std::array<Vec2, 2> direction;
  double weight = 0;      ///< quadrature weight with respect to that parameter
  bool curvature = true;  ///< true: penalise the jump of curvature
  /// True: penalise the jump of the tangent plane. Set it to false if constraints already make the
  /// tangent planes agree.
  bool tangent = true;
};

}  // namespace batten
