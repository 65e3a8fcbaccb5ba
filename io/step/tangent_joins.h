// Where the surfaces beside a line have one tangent plane, which their faces are to keep. Internal.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>
#include <array>

#include "batten/io/step/face_boundary.h"
#include "batten/core/eigen.h"

namespace batten {

/// Surfaces that meet by less than this are tangent: networks join smoothly within 0.1 degrees.
constexpr double kTangentDeg = 0.2;

/// One of the sides of lines: a region's boundary, and the unit normal of its surface at (u, v).
struct TangentSide {
  FaceBoundary* boundary;
  std::function<Vec3(const Vec2& uv)> normal;
};

/// A piece of a line between two of the plan's cuts: the line's name, and how many cuts are before.
using LineSegmentId = std::pair<std::string, int>;
LineSegmentId segment_id_of(const StepPlan& plan, const FaceBoundarySegment& segment);

/// Sets the turns of all stretches that two sides have in common: to normals between those of the two
/// surfaces, smooth along the line and one for all joins that meet in a place. O(stretches).
void find_tangent_joins(const StepPlan& plan, const std::vector<TangentSide>& sides,
                        double tolerance);

/// The angle between two planes by their normals, degrees in [0, 90]: a plane has no side.
double angle_between_planes(const Vec3& a, const Vec3& b);


// Twists of faces at the nodes where smooth joins meet. Internal.

/// The end of a smooth join at a node: the direction of its line from there, the unit normal of both
/// faces, and the derivative of that normal by length along the line.
struct TwistEnd {
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
std::vector<double> matching_twists(const std::vector<TwistEnd>& ends,
                                    const std::vector<TwistCorner>& corners);

}  // namespace batten
