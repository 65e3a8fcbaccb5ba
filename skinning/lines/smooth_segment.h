// Cuts input lines into the stretches that become C1 cubic curves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/arc_length.h"
#include "batten/fairing/curve_fit.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A stretch is a part of an input curve that has no corners inside, in one direction or the other.
struct SmoothSegment {
  std::string name;  ///< the line's, with ".1", ".2", … when the line was cut at corners
  CharacterLine::Role role;
  /// The stretch, in its own direction; the given curve, of a line that has one.
  std::shared_ptr<const InputCurve> curve;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  std::shared_ptr<const PrescribedCurve> prescribed = {};  ///< in the direction of the line
  std::shared_ptr<const InputCurve> input = {};  ///< with `prescribed`: the line's own curve
  bool constrains_surface = true;

  /// Returns the stretch as a line in the user's direction. `flipped`: `curve` runs against it.
  CharacterLine line(bool flipped) const;
  /// Returns the given curve in the direction of `curve`.
  HermiteCurve prescribed_along(bool flipped) const;
};

/// Cuts lines at their corners; those with a given curve stay whole. Throws InputError: a curve of
/// zero length, or not finite; a given curve with corners, or whose vertices do not ascend from its
/// start to its end with its nodes among them.
std::vector<SmoothSegment> split_at_corners(const CharacterLine& line, double corner_angle);

/// Returns a curve from one parameter to a later one.
std::shared_ptr<const InputCurve> subcurve(std::shared_ptr<const InputCurve> curve, double from,
                                           double to);
/// Returns the curve run backwards.
std::shared_ptr<const InputCurve> reversed(std::shared_ptr<const InputCurve> curve);

/// Returns a curve that ends where and as it starts as a closed one, without an end.
HermiteCurve as_closed_curve(const HermiteCurve& curve);

/// Returns the input itself when it is piecewise cubic (exact_curve) and open, of even enough speed
/// (fastest/slowest ≤ 3), with no segment shorter than `shortest` unless it is the only one, and
/// ends within 1e-8 of its length from `start` and `end`, to which they are moved. Nothing
/// otherwise.
std::optional<HermiteCurve> reuse_cubic_input(const SmoothSegment& segment, double shortest,
                                              const Vec3& start, const Vec3& end);

/// The smallest distances of points from one curve, by samples, which are taken once, and Newton's
/// method. It keeps a reference to the curve.
class CurveDistance {
 public:
  explicit CurveDistance(const InputCurve& curve);
  double operator()(const Vec3& p) const;

 private:
  const InputCurve& curve_;
  std::vector<double> t_;
  std::vector<Vec3> x_;
};

}  // namespace batten
