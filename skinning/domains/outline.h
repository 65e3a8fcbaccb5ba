// Closed loops of lines: assembly, orientation, corners, enclosed area, and curve intersection
// tests.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/skinning/lines/character_line.h"

namespace batten {

/// A closed loop of smooth segments, in the order and direction of the loop. Ends that meet are
/// merged into one point.
struct Outline {
  struct OrientedSegment {
    SmoothSegment segment;  ///< oriented along the loop
    bool flipped;           ///< true if the user's line runs against the loop
    double length;          ///< arc length
    Vec3 start;             ///< start point: the mean of the two ends that meet there
  };
  std::vector<OrientedSegment> segments;
  /// Index of the first segment after each corner. Side c consists of the segments corners[c] …
  /// corners[c+1]-1, cyclic.
  std::vector<int> corners;
  double size = 0;  ///< diagonal of the bounding box of all lines

  /// True if the segment begins at a corner.
  bool is_corner(size_t piece) const;
  std::vector<size_t> side(size_t c) const;  ///< segments of side c
  /// Arc length of side c, model units.
  double side_length(size_t c) const;
  /// End point of a segment: the start of the next one.
  const Vec3& end_of(size_t piece) const { return segments[(piece + 1) % segments.size()].start; }
};

/// Joins outline segments into closed loops. Each loop has the direction of its first segment, and
/// loops are ordered by their first segments. With `reverse_orientation` the first loop is
/// reversed. `gap_tolerance`: ends within this distance are joined, model units.
///
/// Prescribed curves that are listed in the order of one loop are joined in that order, so that the
/// loop may pass through a point twice. Two prescribed curves (CharacterLine::prescribed_curve) make a
/// corner unless their derivative vectors dX/du agree at the common end (relative 1e-12). Other segments make a corner if the direction changes by more
/// than `corner_angle` (degrees).
///
/// Throws InputError, with a message for the user: an open loop (with the gap), three lines at one
/// end, lines that cross or touch, all lines on one straight line, or a loop that mixes prescribed
/// curves with others.
std::vector<Outline> make_loops(const std::vector<SmoothSegment>& segments, double size,
                                double gap_tolerance, double corner_angle,
                                bool reverse_orientation = false);

/// The vertex at which a segment of a loop begins. Both segments that meet there share the position
/// and, unless it is a corner, the unit tangent. `outgoing` is the tangent of the segment that
/// begins there, `incoming` that of the segment before it.
struct LoopVertex {
  Vec3 position, outgoing, incoming;
};
/// Computes the vertex at which segment p begins.
LoopVertex loop_vertex_at(const Outline& outline, size_t p);

/// Adds a warning for each vertex with a kink of more than 1 degree that is not a corner: it will
/// be rounded.
void warn_about_rounded_kinks(const Outline& outline, double corner_angle,
                              std::vector<std::string>& warnings);

/// The loop in the opposite direction.
Outline reversed(const Outline& outline);

// Tests whether input curves cross or touch.

/// Number of chords of a sampled curve.
constexpr int kCurveChords = 48;

/// Samples kCurveChords + 1 points of the curve, evenly spaced in its parameter.
std::vector<Vec3> polyline(const InputCurve& curve);

/// Result of a proximity test of two curves: whether they come closer than a distance, and where.
struct CurveCrossing {
  bool found = false;
  Vec3 where = Vec3::Zero();
};

/// A curve with its sampled polyline and a bounding-box hierarchy, built once for tests against
/// many other curves. The curve must outlive it.
class BoxedCurve {
 public:
  explicit BoxedCurve(const InputCurve& curve);

  /// Tests whether the other curve comes closer than `distance`, first by boxes and polylines, then
  /// on the curves themselves. Points within `skip` of one of `common_ends` do not count. Cost:
  /// O(chords²), far less if the boxes are disjoint.
  CurveCrossing crossing(const BoxedCurve& other, double distance,
                         const std::vector<Vec3>& common_ends, double skip) const;
  /// Tests whether the curve comes closer than `distance` to itself. The point where a closed curve
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

// Enclosed area of a loop, and its interior angles.

/// Computes the unit normal of the loop from its area vector: seen from its tip, the loop runs
/// counter-clockwise. Throws InputError if the area vector vanishes (below 1e-6 · size²).
Vec3 loop_normal(const Outline& outline);
/// True if the area vector of the loop does not vanish (at least 1e-6 · size²).
bool encloses_area(const Outline& outline);
/// Norm of the area vector, which is the area enclosed in projection along loop_normal(), model
/// units².
double enclosed_area(const Outline& outline);

/// Computes the interior angle at each corner, in radians in (0, 2π), or in (0, π) if `convex`.
///
/// Without `convex`, a corner is convex if the loop turns left there. That is decided in projection
/// along loop_normal(). There are two exceptions, decided on developable_triangulation() of the
/// loop: the loop leaves its plane by more than a fifth of the size, or the corner's own plane is
/// within 30 degrees of perpendicular to the loop's plane.
///
/// Throws InputError if the loop has no area vector. It takes microseconds, or up to 10 ms with a
/// triangulation.
std::vector<double> corner_angles(const Outline& outline, bool convex);

}  // namespace batten
