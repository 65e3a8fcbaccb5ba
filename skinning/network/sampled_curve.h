// Character lines made ready for a network: one direction, cut at corners, traced by chords.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten::detail {

/// A part of a curve, forwards or backwards; of a closed curve also across its seam (`to` is then
/// above the curve's end). Parameters run from `from` to `to`, backwards from -to to -from.
class TrimmedCurve final : public InputCurve {
 public:
  TrimmedCurve(std::shared_ptr<const InputCurve> whole, double from, double to, bool backwards)
      : whole_(std::move(whole)), from_(from), to_(to), backwards_(backwards) {}
  double start() const override { return backwards_ ? -to_ : from_; }
  double end() const override { return backwards_ ? -from_ : to_; }
  /// Derivatives at both ends are those of the part's own side.
  Vec3 evaluate(double t, int order) const override;
  std::vector<double> breaks() const override;
  std::vector<double> corners() const override;
  bool piecewise_cubic() const override { return whole_->piecewise_cubic(); }

  /// The part from a to b in this piece's own parameter, or from b to a.
  std::shared_ptr<const TrimmedCurve> part(double a, double b, bool back) const;
  /// Parameter of the whole curve at which the piece begins, in the curve's direction.
  double first() const { return from_; }
  bool backwards() const { return backwards_; }

 private:
  std::shared_ptr<const InputCurve> whole_;
  double from_, to_;
  bool backwards_;
};

/// A line, or a piece of one between corners, in its canonical direction.
struct SampledCurve {
  int line = 0;  ///< index into the lines as they were given
  std::shared_ptr<const TrimmedCurve> curve;
  std::shared_ptr<const ArcLength> arc_length;
  double length = 0;
  bool closed = false;                       ///< smooth all around; it starts at a canonical point
  std::array<bool, 2> corner{false, false};  ///< its start, end is a corner of its line
  /// Points of it with their parameters and arc lengths; between two of them it turns by about 0.4
  /// at most and stays within `sag` of the chord.
  std::vector<double> t, s;
  std::vector<Vec3> x;
  std::vector<double> sag;

  int segments() const { return isize(sag); }
  Vec3 point(double parameter) const { return curve->evaluate(parameter, 0); }
  double end_parameter(int end) const { return end ? curve->end() : curve->start(); }
  Vec3 end_point(int end) const { return end ? x.back() : x.front(); }
  /// Arc length between two places; the shorter way around where closed.
  double between(double s0, double s1) const;
  /// Nearest parameter to p within [low, high], from `t` on; Newton, a local minimum.
  double closest_parameter(const Vec3& p, double t, double low, double high) const;
};

struct SampledCurves {
  std::vector<SampledCurve> sampled_curves;  ///< strands in canonical order
  /// Ends (strand, 0 or 1) that a corner of a line joins.
  std::vector<std::array<std::pair<int, int>, 2>> corners;
  /// Of each line those that are equal to it in every point; they have no strands of their own.
  std::vector<std::vector<int>> duplicates;
  Vec3 origin = Vec3::Zero();  ///< centre of the box
  double size = 0;             ///< diagonal of the box around all points
};

/// Unit tangent at t, seen from the side of larger parameters (+1) or smaller ones (-1); where the
/// derivative vanishes, from a point nearby.
Vec3 tangent(const InputCurve& curve, double t, int side);

/// Lexicographic order along three fixed directions without meaning: 0 where the points agree
/// within eps.
int compare(const Vec3& p, const Vec3& q, double eps);

/// A key for sorting points, the same on repetition and on any scale: rounded to 2⁻²⁶ of the size.
std::array<long long, 3> sort_key(const Vec3& p, const Vec3& origin, double size);

/// Throws InputError for lines that are no lines (network.h). Each line gets the direction that the
/// first difference between its two ends, or of points as far from either end, gives it; strands
/// are in the order of start, end and middle, equal ones in that of their lines' names. Of lines that
/// are equal in every point, the first by name has strands.
SampledCurves make_sampled_curves(const std::vector<CharacterLine>& lines, double corner_angle);


// Inside of find_contacts: how far two strands are from each other, and where.

/// Distance of two straight pieces a0 a1 and b0 b1; s and t in [0, 1] become the nearest places on
/// them.
double chord_distance(const Vec3& a0, const Vec3& a1, const Vec3& b0, const Vec3& b1, double& s,
                      double& t);

/// Parameters around a segment of a strand within which its nearest point is looked for.
std::array<double, 2> bracket(const SampledCurve& sampled_curve, int segment);

/// Distance of the nearest points of two curves within brackets, from ta and tb on, which become
/// their parameters: Levenberg's steps on both; one that is pushed against its end stays there.
double nearest(const SampledCurve& a, const std::array<double, 2>& range_a, double& ta,
               const SampledCurve& b, const std::array<double, 2>& range_b, double& tb);

}  // namespace batten::detail
