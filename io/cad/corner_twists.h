// Twists of faces at the nodes where smooth joins meet. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// The end of a smooth join at a node: the direction of its line from there, the unit normal of both
/// faces, and the derivative of that normal by length along the line.
struct JoinEnd {
  Vec3 along, normal, slope;
};

/// The corner of a face between two ends of joins, and +1, or -1 where the face's normal is opposite to
/// that of the end.
struct TwistCorner {
  std::array<int, 2> ends;
  std::array<double, 2> sign;
};

/// A face with one curvature in its corner has the same twist from both sides: n₁'·t₂ = n₂'·t₁. (Surfaces
/// of C1 elements need not: there the angle of a C2 spline decreases with its first knot interval only.)
/// Returns for each end the rate c by which its normals are to turn about their line, n' + c n × t, so that
/// this holds in all corners of a node, as far as it can, with small c:
///
///   min Σ over corners and their two ends |n' + c n × t + B t|² + ε Σ c²,  B symmetric, one a corner
///
/// One sparse factor of size 3 corners + ends.
std::vector<double> matching_twists(const std::vector<JoinEnd>& ends,
                                    const std::vector<TwistCorner>& corners);

}  // namespace batten
