// SPDX-License-Identifier: MPL-2.0
// Local maxima of functions inside a triangle of a mesh.
#pragma once

#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Moves a location inside its triangle to a local maximum of `value(Location)` by compass search.
/// `accuracy`: last step, in barycentric coordinates. Cost: about 6 log2(1/accuracy) evaluations.
template <class Value>
Location climb_in_triangle(Location where, double accuracy, const Value& value) {
  double largest = value(where);
  constexpr double first = 0.25;
  for (double step = first; step > accuracy;) {
    Location best = where;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const Location next{where.triangle, where.L + step * (Vec3::Unit(i) - Vec3::Unit(j))};
        if (next.L.minCoeff() < 0) continue;
        if (const double there = value(next); there > largest) {
          largest = there;
          best = next;
        }
      }
    if (best.L == where.L) step /= 2;
    where = best;
  }
  return where;
}

}  // namespace batten
