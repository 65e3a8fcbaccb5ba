// Boxes along the axes.
#pragma once

#include <type_traits>

#include "batten/core/eigen.h"

namespace batten {

using Box2 = Eigen::AlignedBox2d;
using Box3 = Eigen::AlignedBox3d;

/// The smallest box around points of the plane or of space; without points the empty one.
template <class PointRange>
auto bounding_box(const PointRange& points) {
  using Point = std::decay_t<decltype(*points.begin())>;
  Eigen::AlignedBox<double, Point::RowsAtCompileTime> box;
  for (const Point& p : points) box.extend(p);
  return box;
}

}  // namespace batten
