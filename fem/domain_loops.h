// Regions of the (u, v) plane that cubic curves bound.
#pragma once

#include <vector>

#include "batten/core/box.h"
#include "batten/fem/hermite_curve.h"
#include "batten/fem/planar_cubic.h"

namespace batten {

/// What lies to the left of closed loops: an outside loop runs counter-clockwise, a hole clockwise.
/// Loops must not cross. Immutable.
///
/// Curves of the plane are HermiteCurves with z = 0. A loop is one closed curve, or several open
/// ones end to end.
class DomainLoops {
 public:
  using Loop = std::vector<HermiteCurve>;
  /// What is far away: outside of the region, or inside of it (there are holes only, and something
  /// else bounds the region).
  enum class Background { Outside, Inside };

  /// A region without loops: the whole plane, or nothing.
  explicit DomainLoops(Background background = Background::Inside)
      : background_(background), box_(Vec2(0, 0)) {}
  /// Throws InputError: a curve that leaves the plane z = 0, pieces of a loop that do not meet end
  /// to end (within 1e-9 of the box of all loops), an empty loop.
  explicit DomainLoops(std::vector<Loop> loops, Background background = Background::Outside);

  const std::vector<Loop>& loops() const { return loops_; }
  /// All segments, loop after loop, with exactly shared ends.
  const std::vector<PlanarCubic>& segments() const { return segments_; }
  Background background() const { return background_; }

  /// Whether p is inside, by the winding number of a ray against the cubics themselves: exact to
  /// rounding; on a curve either answer. O(segments at the height of p).
  bool contains(const Vec2& p) const;
  /// Area that is enclosed; with Around::Inside, minus the area of the holes. Exact.
  double area() const;
  Vec2 low() const { return box_.min(); }
  Vec2 high() const { return box_.max(); }

 private:
  // A part of an arc on which v is monotone.
  struct Monotone {
    int segment;
    double t0, t1, v0, v1, u_low, u_high;
  };
  void sort_into_bands();
  size_t band(double v) const;  // never falls with v
  Background background_;
  std::vector<Loop> loops_;
  std::vector<PlanarCubic> segments_;
  std::vector<Monotone> monotone_;
  // The numbers of the parts that reach into each band of v: from bands_[i] to bands_[i + 1].
  std::vector<int> in_bands_;
  std::vector<size_t> bands_ = {0, 0};
  Box2 box_;
};

}  // namespace batten
