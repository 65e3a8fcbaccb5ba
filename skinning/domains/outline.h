// Closed loops of lines, and where their lines join.
#pragma once

#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/lines/smooth_segment.h"

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

}  // namespace batten
