// Closed loops of lines, and where their lines join.
#pragma once

#include <string>
#include <vector>
#include <array>
#include <limits>

#include "batten/core/eigen.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// Stretches in the order and direction of their loop, merged where they meet.
struct Outline {
  struct OrientedSegment {
    SmoothSegment segment;  ///< runs along the loop
    bool flipped;           ///< the user's line runs the other way
    double length;          ///< arc length
    Vec3 start;             ///< where it begins: the mean of the two ends that meet there
  };
  std::vector<OrientedSegment> segments;
  /// Index of the first piece after each corner: side c is pieces corner[c] … corner[c+1]-1,
  /// cyclic.
  std::vector<int> corners;
  double size = 0;  ///< diagonal of the box of all lines

  bool is_corner(size_t piece) const;
  std::vector<size_t> side(size_t c) const;  ///< pieces of side c
  double side_length(size_t c) const;
  const Vec3& end_of(size_t piece) const { return segments[(piece + 1) % segments.size()].start; }
};

/// Joins outline stretches into closed loops, each in the direction of its first stretch and in the
/// order of these; with `reverse_orientation` the first loop runs the other way. Ends meet within `gap_tolerance`
/// (model units). Given curves that are listed in the order of one loop are joined in that order,
/// so that it may come through one place twice. Two given curves make a corner unless their slopes
/// are the same vector (1e-12), other stretches where they turn by more than `corner_angle`
/// (degrees). Throws InputError in words for the user: an open loop (with the gap), three lines at
/// one end, lines that cross or touch, all lines on one line, given curves with others in one loop.
std::vector<Outline> make_loops(const std::vector<SmoothSegment>& segments, double size,
                                double gap_tolerance, double corner_angle,
                                bool reverse_orientation = false);

/// The place where a piece of a loop begins. Both pieces that meet there take the same point and,
/// unless it is a corner, the same unit tangent: `outgoing` is that of the piece, `incoming` that
/// of the piece before it.
struct LoopVertex {
  Vec3 position, outgoing, incoming;
};
/// Returns the joint at which piece p begins.
LoopVertex loop_vertex_at(const Outline& outline, size_t p);

/// Adds a warning for each joint that turns noticeably, but less than a corner: it will be rounded.
void warn_about_rounded_kinks(const Outline& outline, double corner_angle,
                              std::vector<std::string>& warnings);

/// Returns the loop the other way around.
Outline reversed(const Outline& outline);


// Finds where input curves cross or touch.

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


// Computes the area that a loop of lines encloses, and its angles seen from that side.

/// Returns the unit area vector of the loop: it points to the side from which the loop runs
/// counter-clockwise. Throws InputError when it encloses no area seen from any side.
Vec3 loop_normal(const Outline& outline);
/// Returns whether it encloses an area seen from some side.
bool encloses_area(const Outline& outline);
/// Returns the area that it encloses seen from the side of loop_normal(), model units².
double enclosed_area(const Outline& outline);

/// Returns the interior angle at each corner, radians in (0, 2π); `convex`: in (0, π). Otherwise, whether the loop turns to the
/// left or to the right there is seen from the loop's side, or from the side of its developable
/// filling where the loop leaves its plane by more than a fifth of the size, or the corner stands
/// upright on it within 30 degrees. Throws InputError when
/// the loop encloses no area seen from any side. It takes microseconds, with a filling up to 10 ms.
std::vector<double> corner_angles(const Outline& outline, bool convex);

}  // namespace batten
