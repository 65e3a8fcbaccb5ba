// Finds where input curves cross or touch.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "batten/fairing/input_curve.h"

namespace batten {

constexpr int kCurveChords = 48;

/// Returns kCurveChords + 1 points of the curve, evenly over its parameter.
std::vector<Vec3> polyline(const InputCurve& curve);

/// Whether two curves come closer than a distance, and where.
struct CurveCrossing {
  bool found = false;
  Vec3 where = Vec3::Zero();
};

/// A curve with its polyline in boxes: made once for tests against many others. The curve must
/// outlive it.
class BoxedCurve {
 public:
  explicit BoxedCurve(const InputCurve& curve);

  /// Finds whether the other curve comes closer than `distance`, first by boxes and polylines, then
  /// on the curves. Places within `skip` of the points `common_ends` do not count.
  /// O(chords²), far less where boxes are apart.
  CurveCrossing crossing(const BoxedCurve& other, double distance,
                         const std::vector<Vec3>& common_ends, double skip) const;
  /// Finds whether the curve comes closer than `distance` to itself; the place where a closed one
  /// closes does not count.
  CurveCrossing self_crossing(double distance) const;

 private:
  static constexpr int kChordsInBox = 8;
  struct Box {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    bool meets(const Box& other, double distance) const;
    void add(const Vec3& p, double around);
  };
  bool chords_meet(int i, const BoxedCurve& other, int j, double distance) const;

  const InputCurve* curve_;
  std::vector<Vec3> points_;
  std::array<Box, kCurveChords / kChordsInBox> parts_;
  Box all_;
};

}  // namespace batten
