// SPDX-License-Identifier: MPL-2.0
// Closed loops of curves: assembly, orientation, corners, enclosed area, and curve intersection
// tests.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// Thrown if curves of the outline of a face intersect.
class OutlineIntersection : public InputError {
 public:
  /// `curves`: the names of the two curves that intersect, or of the one that intersects itself.
  OutlineIntersection(const std::string& message, std::vector<std::string> curves)
      : InputError(message), curves_(std::move(curves)) {}
  const std::vector<std::string>& curves() const { return curves_; }

 private:
  std::vector<std::string> curves_;
};

/// A closed loop of smooth segments, in the order and direction of the loop. The ends of
/// consecutive segments are merged into one point.
struct Outline {
  struct OrientedSegment {
    SmoothSegment segment;  ///< smooth part of an input curve, in the loop direction
    bool flipped;           ///< true: the input curve runs against the loop
    double length;          ///< arc length, model units
    Vec3 start;             ///< start point: mean of the two joined curve ends
  };
  std::vector<OrientedSegment> segments;
  /// Index of the first segment after each corner. Side c of the loop consists of the segments from
  /// corners[c] to corners[c + 1] - 1, cyclically.
  std::vector<int> corners;
  double size = 0;  ///< diagonal of the bounding box of all curves, model units

  /// True if the segment with index `piece` starts at a corner.
  bool is_corner(size_t piece) const;
  /// Indices of the segments of side c, from corner c to the next corner.
  std::vector<size_t> side(size_t c) const;
  /// Arc length of side c, from corner c to the next corner, model units.
  double side_length(size_t c) const;
  /// End point of a segment, which is the start of the next segment.
  const Vec3& end_of(size_t piece) const { return segments[(piece + 1) % segments.size()].start; }
};

/// Joins smooth curve segments at their ends into closed loops. Each loop has the direction of its
/// first segment, and loops are ordered by their first segments. `reverse_orientation`: reverses
/// the first loop. `gap_tolerance`: ends within this distance are joined, model units. `size`:
/// diagonal of the bounding box of all curves.
///
/// Prescribed curves that are listed in the order of one loop are joined in that order, so that the
/// loop may pass through a point twice. Two prescribed curves (CharacterLine::prescribed) make a
/// corner unless their derivative vectors agree at the common end (relative 1e-12). Other segments
/// make a corner if the direction changes by more than `corner_angle` (degrees), or if both are
/// parts of a curve that has a corner there.
///
/// Throws OutlineIntersection for curves that cross or touch, and InputError for an open loop (the
/// message contains the gap), three curves that meet at one point, curves that all lie on one
/// straight line, or a loop in which only some of the curves are prescribed.
std::vector<Outline> make_loops(const std::vector<SmoothSegment>& segments, double size,
                                double gap_tolerance, double corner_angle,
                                bool reverse_orientation = false);

/// The point between two consecutive segments of a loop of curves, with unit tangents. `incoming`:
/// tangent at the end of the previous segment. `outgoing`: tangent at the start of the next
/// segment. The tangents are equal unless the point is a corner.
struct LoopVertex {
  Vec3 position, outgoing, incoming;
};
/// Computes the position and the tangents of a loop at the start of its segment `p`.
LoopVertex loop_vertex_at(const Outline& outline, size_t p);

/// Adds a warning for each kink between two segments above 1 degree and up to `corner_angle`
/// (degrees), because the fitted outline rounds such a kink.
void warn_about_rounded_kinks(const Outline& outline, double corner_angle,
                              std::vector<std::string>& warnings);

/// The loop `outline` in the opposite direction.
Outline reversed(const Outline& outline);

// Tests whether input curves cross or touch.

/// Number of chords of the polyline that approximates a curve in intersection tests.
constexpr int kCurveChords = 48;

/// Samples kCurveChords + 1 points of a curve, evenly spaced in its parameter.
std::vector<Vec3> polyline(const InputCurve& curve);

/// Result of a proximity test of two curves. `found`: true if they come closer than the given
/// distance. `where`: the position at which they do.
struct CurveCrossing {
  bool found = false;
  Vec3 where = Vec3::Zero();
};

/// A curve with a sampled polyline and a bounding-box hierarchy, for proximity tests with many
/// other curves. The curve must outlive this object.
class BoxedCurve {
 public:
  explicit BoxedCurve(const InputCurve& curve);

  /// Tests whether this curve and `other` come closer than `distance`: first with bounding boxes
  /// and polylines, then with the curves. Points within the distance `skip` of a point in
  /// `common_ends` are ignored. All distances are in model units. Cost: O(chords²), far less if the
  /// boxes are disjoint.
  CurveCrossing crossing(const BoxedCurve& other, double distance,
                         const std::vector<Vec3>& common_ends, double skip) const;
  /// Tests whether the curve comes closer than `distance` (model units) to itself. The common start
  /// and end point of a closed curve is ignored.
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

// Enclosed area of a loop, and its interior angles.

/// Computes the unit normal of a closed loop of curves: the direction of its area vector ½ ∮ x ×
/// dx. The loop is counter-clockwise seen from the tip of the normal. Throws InputError if the area
/// vector is shorter than 1e-6 · Outline::size².
Vec3 loop_normal(const Outline& outline);
/// True if the area vector ½ ∮ x × dx of the loop has at least the length 1e-6 · Outline::size².
bool encloses_area(const Outline& outline);
/// Length of the area vector ½ ∮ x × dx of a closed loop of curves, model units². This is the area
/// that the projection of the loop along loop_normal() encloses.
double enclosed_area(const Outline& outline);

/// Computes the interior angle at each corner of a loop: radians in (0, 2π), or (0, π) if `convex`.
///
/// If `convex` is false, a corner is convex if the loop turns left there, in the projection along
/// loop_normal(). In two cases, developable_triangulation() of the loop is used instead of the
/// projection: if the loop deviates from a plane by more than a fifth of its size, or if the plane
/// of the two curves at the corner is within 30 degrees of perpendicular to the plane of the loop.
/// If the sum of the angles from the triangulation is farther from that of a polygon, (n - 2) π,
/// than it is with all corners convex, all corners are convex.
///
/// Throws as loop_normal() does. Cost: microseconds, or up to 10 ms if the triangulation is needed.
std::vector<double> corner_angles(const Outline& outline, bool convex);

}  // namespace batten
