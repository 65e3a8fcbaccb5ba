// The closed loop of lines around a region, and the polygon it becomes.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/line_fit.h"

namespace batten {

/// Stretches in the order and direction of their loop, merged where they meet.
struct Outline {
  struct Piece {
    Stretch stretch;  ///< runs along the loop
    bool flipped;     ///< the user's line runs the other way
    double length;    ///< arc length
    Vec3 start;       ///< where it begins: the mean of the two ends that meet there
  };
  std::vector<Piece> pieces;
  /// Index of the first piece after each corner: side c is pieces corner[c] … corner[c+1]-1,
  /// cyclic.
  std::vector<int> corners;
  double size = 0;  ///< diagonal of the box of all lines

  bool is_corner(size_t piece) const;
  const Vec3& end_of(size_t piece) const { return pieces[(piece + 1) % pieces.size()].start; }
};

/// Joins outline stretches into closed loops, each in the direction of its first stretch, in the
/// order of those; `against_first`: the first loop the other way. Ends meet within `join` (model
/// units). Given curves that are listed in the order of one loop are joined in that order, so that
/// it may come through one place twice. Two given curves make a corner unless their slopes are the
/// same vector (1e-12), other stretches where they turn by more than `corner_angle` (degrees).
/// Throws InputError in words for the user: an open loop (with the gap), three lines at one end,
/// lines that cross or touch, all lines on one line, given curves with others in one loop.
std::vector<Outline> make_loops(const std::vector<Stretch>& stretches, double size, double join,
                                double corner_angle, bool against_first = false);

/// Where piece p of a loop begins: both neighbours take the same point and, unless it is a corner,
/// the same tangent. `incoming` is what the piece before it takes.
struct Joint {
  Vec3 position, outgoing, incoming;
};
Joint joint_at(const Outline& outline, size_t p);

/// Text for each joint that turns noticeably, but less than a corner: it will be rounded.
void warn_of_smoothed_joints(const Outline& outline, double corner_angle,
                             std::vector<std::string>& warnings);

/// The loop the other way around.
Outline reversed(const Outline& outline);

/// Interior angle at each corner, radians in (0, 2π): whether it turns to the left or to the right
/// is seen from the loop's side, or from that of its developable filling where the loop is not
/// nearly plane (out of it by more than a fifth of the size). Throws InputError when the loop
/// encloses no area seen from any side.
std::vector<double> corner_angles(const Outline& outline);

/// A simple counter-clockwise polygon with the given side lengths and interior angles as nearly as
/// they can be had together, by least squares over log lengths, angles and (weakly, up to 24
/// corners) distances between corners that are shorter than in space. Angles φ weigh |cot φ| where
/// that is above 1, because the surface's Jacobian at a corner is sin φ / sin θ of the polygon's
/// angle θ: nearly straight and sharp corners keep theirs, wide ones give way. Beyond half and
/// twice that Jacobian a wall rises, so that a corner does not turn the other way
/// (polygon_fit.cpp). `corners`: the corners in space, for the start and those distances; `normal`:
/// the side from which the loop runs counter-clockwise. Scale: sides keep their length on average.
/// Throws InputError when no simple polygon is found. O(steps · corners³), below a millisecond
/// for 30.
std::vector<Vec2> fit_polygon(const std::vector<double>& lengths, const std::vector<double>& angles,
                              const std::vector<Vec3>& corners, const Vec3& normal);

/// Unit area vector of the loop: the side from which it runs counter-clockwise. Throws InputError
/// when it encloses no area seen from any side.
Vec3 loop_normal(const Outline& outline);
bool encloses_area(const Outline& outline);
/// Seen from that side, model units².
double enclosed_area(const Outline& outline);

/// Whether no sides of the polygon meet but neighbours at their corner, and its area is positive.
/// O(n²).
bool simple_and_ccw(const std::vector<Vec2>& polygon);

/// A polygon whose sides and interior angles are as nearly as they can be those given, all angles
/// alike, begun with a circle and simple throughout. For sampled smooth outlines, at most about a
/// hundred corners. Throws InputError like fit_polygon().
std::vector<Vec2> relax_polygon(const std::vector<double>& lengths,
                                const std::vector<double>& angles);

/// Whether two curves come closer than `distance`, and where: by polylines first, then on the
/// curves. Near common ends (within `skip` of their points) closeness is no crossing.
struct Crossing {
  bool found = false;
  Vec3 where = Vec3::Zero();
};
Crossing find_crossing(const InputCurve& a, const InputCurve& b, double distance,
                       const std::vector<Vec3>& common_ends, double skip);
Crossing find_self_crossing(const InputCurve& a, double distance);

}  // namespace batten
