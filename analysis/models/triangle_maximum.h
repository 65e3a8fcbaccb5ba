// SPDX-License-Identifier: MPL-2.0
// Maximum of a function on a surface mesh: the largest sample, and a local maximum around it.
#pragma once

#include <algorithm>
#include <vector>

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

/// The locations of the largest sample of a function. There may be several, because a vertex is a
/// location in each of the triangles around it.
class LargestSamples {
 public:
  void take(const Location& where, double value) {
    constexpr double same = 1e-9;
    if (!(value > (1 - same) * largest_)) return;
    if (value > (1 + same) * largest_) places_.clear();
    largest_ = std::max(largest_, value);
    places_.push_back(where);
  }

  /// True if no sample is above 0.
  bool empty() const { return places_.empty(); }

  /// The largest local maximum in the triangles of these locations (climb_in_triangle()). There must
  /// be a location. `may_climb(triangle)`: whether the function is defined on the whole triangle.
  template <class Value, class MayClimb>
  Location climb(double accuracy, const Value& value, const MayClimb& may_climb) const {
    constexpr size_t few = 24;  // of a constant function, all samples are the largest
    Location best = places_[0];
    for (size_t i = 0; i < std::min(places_.size(), few); ++i) {
      if (!may_climb(places_[i].triangle)) continue;
      const Location top = climb_in_triangle(places_[i], accuracy, value);
      if (value(top) > value(best)) best = top;
    }
    return best;
  }

 private:
  double largest_ = 0;
  std::vector<Location> places_;
};

}  // namespace batten
