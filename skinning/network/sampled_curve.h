// SPDX-License-Identifier: MPL-2.0
// Prepares input curves for a curve network: canonical direction, split at corners, sampled by
// chords.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten::detail {

/// A part of a curve, optionally reversed. The part of a closed curve may cross its seam; `to` then
/// exceeds the end parameter of the whole curve.
///
/// The parameter runs from `from` to `to`, or from -to to -from if the part is reversed.
class TrimmedCurve final : public InputCurve {
 public:
  TrimmedCurve(std::shared_ptr<const InputCurve> whole, double from, double to, bool backwards);
  double start() const override { return backwards_ ? -to_ : from_; }
  double end() const override { return backwards_ ? -from_ : to_; }
  /// Evaluates a point or derivative. At the ends, derivatives are one-sided, taken from inside the
  /// part.
  Vec3 evaluate(double t, int order) const override;
  std::vector<double> breaks() const override;
  std::vector<double> corners() const override;
  bool piecewise_cubic() const override { return whole_->piecewise_cubic(); }

  /// The part between a and b, in this part's own parameter; reversed if `back`.
  std::shared_ptr<const TrimmedCurve> part(double a, double b, bool back) const;
  /// Parameter of the whole curve at which this part starts, in the direction of the whole curve.
  double first() const { return from_; }
  bool backwards() const { return backwards_; }

 private:
  using Parameters = std::shared_ptr<const std::vector<double>>;

  std::shared_ptr<const InputCurve> whole_;
  Parameters given_breaks_, given_corners_;  ///< of the whole curve; all its parts share them
  double from_, to_;
  bool backwards_;
};

/// An input curve, or the segment of one between two corners, in its canonical direction and
/// sampled by chords.
struct SampledCurve {
  int line = 0;  ///< index into the input curves
  std::shared_ptr<const TrimmedCurve> curve;
  std::shared_ptr<const ArcLength> arc_length;
  double length = 0;
  bool closed = false;  ///< closed and smooth at the seam; starts at a canonical point
  std::array<bool, 2> corner{false, false};  ///< the start (end) is a corner of its input curve
  /// Sample points x with their parameters t and arc lengths s. Between two samples the curve turns
  /// by at most about 0.4 rad and stays within `sag` (one value per chord) of the chord.
  std::vector<double> t, s;
  std::vector<Vec3> x;
  std::vector<double> sag;

  int segments() const { return isize(sag); }
  Vec3 point(double parameter) const { return curve->evaluate(parameter, 0); }
  double end_parameter(int end) const { return end ? curve->end() : curve->start(); }
  Vec3 end_point(int end) const { return end ? x.back() : x.front(); }
  /// Distance along the curve between two arc lengths; on a closed curve, the shorter one of the
  /// two.
  double between(double s0, double s1) const;
  /// Parameter of the point closest to p within [low, high]: a local minimum, found by Newton's
  /// method from `t`.
  double closest_parameter(const Vec3& p, double t, double low, double high) const;
};

/// All sampled curves of a network, with its size.
struct SampledCurves {
  std::vector<SampledCurve> sampled_curves;  ///< in canonical order
  /// Pairs of curve ends (sampled curve, 0 or 1) that were one corner of an input curve.
  std::vector<std::array<std::pair<int, int>, 2>> corners;
  /// For each input curve, the other input curves that equal it in every point. These have no
  /// sampled curves of their own.
  std::vector<std::vector<int>> duplicates;
  Vec3 origin = Vec3::Zero();  ///< centre of the bounding box
  double size = 0;             ///< diagonal of the bounding box of all points, model units
};

/// One-sided unit tangent at t, from larger (side = +1) or smaller (side = -1) parameters. If the
/// derivative vanishes, a chord to a nearby point is used.
Vec3 tangent(const InputCurve& curve, double t, int side);

/// Compares points lexicographically along three fixed, generic directions; 0 if they agree within
/// `eps`.
int compare(const Vec3& p, const Vec3& q, double eps);

/// Sort key of a point: coordinates along fixed directions relative to `origin`, rounded to 2⁻²⁶ of
/// `size`. Reproducible, and independent of the scale.
std::array<long long, 3> sort_key(const Vec3& p, const Vec3& origin, double size);

/// Splits the input curves at corners (`corner_angle`, degrees) and samples them.
///
/// Each curve gets a canonical direction, from the first difference between its two ends, or else
/// between points equally far from either end. Sampled curves are ordered by their start, end and
/// middle points, equal ones by the names of their input curves. Of input curves that are equal in
/// every point, only the first by name is sampled. Throws InputError for invalid curves (see
/// CurveNetwork).
SampledCurves make_sampled_curves(const std::vector<CharacterLine>& lines, double corner_angle);

// Implementation details of find_contacts(): distance between two curves and the closest points.

/// Distance between the segments a0 a1 and b0 b1. On return, s and t in [0, 1] are the positions of
/// the closest points on them.
double chord_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double& s,
                      double& t);

/// Parameter range around a chord in which the closest point is sought: the chord, extended by a
/// quarter of its range on both sides.
std::array<double, 2> bracket(const SampledCurve& sampled_curve, int segment);

/// Distance between the closest points of two curves within parameter ranges.
///
/// `ta`, `tb`: starting parameters, replaced by those of the closest points. Method:
/// Levenberg–Marquardt on both parameters; a parameter whose step points out of its range is fixed
/// at the bound.
double nearest(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
               const SampledCurve& b, const std::array<double, 2>& range_b, double& tb);

}  // namespace batten::detail
