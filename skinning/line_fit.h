// From input lines to C1 cubic Hermite curves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fem/curve.h"
#include "batten/skinning/character_line.h"

namespace batten {

/// A stretch of an input curve without corners inside, in one direction or the other.
struct Stretch {
  std::string name;  ///< the line's, with ".1", ".2", … when the line was cut at corners
  CharacterLine::Role role;
  std::shared_ptr<const InputCurve> curve;  ///< of the whole stretch, in its own direction
};

/// Cuts lines at their corners. Throws InputError: a curve of zero length, or not finite.
std::vector<Stretch> cut_at_corners(const CharacterLine& line, double corner_angle);

/// The curve run backwards.
std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve);

/// Arc length of an input curve, and its inverse: panels of Gauss points, 1e-12 on smooth curves.
class ArcLength {
 public:
  explicit ArcLength(std::shared_ptr<const InputCurve> curve);
  double total() const { return length_.back(); }
  /// Parameter t at arc length s from the start.
  double parameter(double s) const;

 private:
  std::shared_ptr<const InputCurve> curve_;
  std::vector<double> t_, length_;
};

/// Where a fitted curve begins or ends.
struct LineEnd {
  Vec3 position;
  Vec3 tangent;  ///< unit, along the stretch
};

/// A curve with nodes by repeated halving of arc length until it is within `tolerance` of the
/// input; its parameter is arc length from 0. Nodes lie on the input with its unit tangent, except
/// the ends, which are as given: where neighbours meet, they must agree. Throws InputError when
/// 2^14 segments do not do.
HermiteCurve fit_by_bisection(const Stretch& stretch, double tolerance, const LineEnd& start,
                              const LineEnd& end);

/// The input itself when it is piecewise cubic, C1, of even enough speed (fastest/slowest ≤ 3),
/// with no piece shorter than `shortest` and ends within 1e-8 of its length from `start` and `end`,
/// to which they are moved; otherwise a curve without nodes. The parameter is scaled to end - start
/// = arc length.
HermiteCurve exact_cubic(const Stretch& stretch, double shortest, const Vec3& start,
                         const Vec3& end);

/// Nearest distance from p to the curve: samples, then Newton's method.
double distance_to(const InputCurve& curve, const Vec3& p);

}  // namespace batten
