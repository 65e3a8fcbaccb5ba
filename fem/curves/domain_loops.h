// SPDX-License-Identifier: MPL-2.0
// Regions of the (u, v) plane bounded by loops of cubic curves.
#pragma once

#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/cubic.h"
#include "batten/fem/curves/hermite_curve.h"

namespace batten {

/// Converts a curve in the plane z = 0 to planar cubics, one per segment.
std::vector<PlanarCubic> planar_cubics(const HermiteCurve& curve);

/// Region of the (u, v) plane to the left of closed loops: an outer loop runs counter-clockwise, a
/// hole clockwise. Loops must not intersect. Immutable.
///
/// A loop is one closed HermiteCurve with z = 0, or several open ones joined end to end.
class DomainLoops {
 public:
  using Loop = std::vector<HermiteCurve>;
  /// Whether points far from all loops lie outside of the region or inside. Inside: all loops are
  /// holes in an unbounded region.
  enum class Background { Outside, Inside };

  /// Constructs a region without loops: the whole plane (Inside) or an empty region (Outside).
  explicit DomainLoops(Background background = Background::Inside)
      : background_(background), box_(Vec2(0, 0)) {}
  /// Constructs the region to the left of the given loops. Throws InputError if a curve leaves the
  /// plane z = 0, if consecutive curves of a loop do not meet (within 1e-9 of the bounding box of
  /// all loops), or if a loop is empty.
  explicit DomainLoops(std::vector<Loop> loops, Background background = Background::Outside);

  const std::vector<Loop>& loops() const { return loops_; }
  /// Cubic arcs of all loops, loop after loop; the common ends of consecutive arcs are
  /// bit-identical.
  const std::vector<PlanarCubic>& segments() const { return segments_; }
  Background background() const { return background_; }

  /// Whether the point p = (u, v) is inside the region. The winding number is computed from the
  /// intersections of a ray with the cubic arcs, exact to rounding. For points on a boundary arc,
  /// either result is possible. Cost: O(arcs that intersect the line v = const through p).
  bool contains(const Vec2& p) const;
  /// Exact area of the region in (u, v); with Background::Inside, minus the area of the holes.
  double area() const;
  Vec2 low() const { return box_.min(); }
  Vec2 high() const { return box_.max(); }

 private:
  // Part of an arc on which v is monotone.
  struct Monotone {
    int segment;
    double t0, t1, v0, v1, u_low, u_high;
  };
  void sort_into_bands();
  size_t band(double v) const;  // monotone in v
  Background background_;
  std::vector<Loop> loops_;
  std::vector<PlanarCubic> segments_;
  std::vector<Monotone> monotone_;
  // Indices of the parts that intersect each band of v, from bands_[i] to bands_[i + 1].
  std::vector<int> in_bands_;
  std::vector<size_t> bands_ = {0, 0};
  Box2 box_;
};

}  // namespace batten
