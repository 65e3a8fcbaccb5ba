// SPDX-License-Identifier: MPL-2.0
// Interpolates points by a curve of straight lines, circular arcs and cubic splines.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/fairing/curves/input_curve.h"

namespace batten {

/// Interpolates points in the given order by a curve that is C1 between corners.
///
/// Between corners, the curve consists of
///
/// - straight lines and circular arcs, wherever points lie on one (find_lines_and_arcs()). Lines
///   are exact. Arcs deviate from the circle by 4e-6 of the radius if the points are 45 degrees
///   apart; this error grows with the sixth power of the angle.
/// - C2 cubic splines over chord length elsewhere. A spline continues adjacent lines and arcs
///   tangentially. At corners and ends its last piece is a parabola, so three points give a
///   parabola unless they are recognised as an arc.
///
/// `corners`: point indices (from 0). If unset, corners are detected by find_corners() with the
/// smallest turning angle `corner_angle`, degrees. `name` is used in messages.
///
/// If the last point equals the first, the curve is closed. It is smooth at that point, unless the
/// point is a corner. The speed |dX/du| is 1 on lines and arcs. Throws InputError for fewer than
/// two points, a number that is not finite, two successive points that coincide (closer than 1e-9
/// of the size), points that all coincide, and an index in `corners` that is out of range. Cost:
/// O(points), plus that of find_corners().
std::shared_ptr<const InputCurve> curve_through_points(
    const std::string& name, const std::vector<Vec3>& points, double corner_angle = 20,
    const std::optional<std::vector<int>>& corners = {});

// Recognition of straight lines and circular arcs among ordered points.

/// Points first … last of a sequence that lie on a straight line or on a circular arc, with the
/// unit tangents at these points.
struct LineOrArc {
  int first = 0, last = 0;
  std::vector<Vec3> tangents;
};

/// Finds the straight lines and circular arcs in an open sequence of points without corners.
///
/// The lines and arcs are returned in ascending order. Neighbours may share a point and then have
/// the same tangent there. Points lie on a line or circle if their distance from it is within 5e-5
/// of the chord.
///
/// Dense points of any smooth curve lie nearly on lines and circles, but a spline interpolates them
/// better. Therefore the following conditions also apply:
///
/// - At one of its ends, a straight line turns by at least half a degree and by twenty times as
///   much as inside (three points: a thousand times).
/// - An arc has the same curvature, within 2 %, at all of its points, and a curvature that differs
///   by at least a fifth at its ends.
/// - A line has three points or more. Three points at an inflection, with turns of opposite sign
///   before and behind, are not a line, because symmetric curves have such points.
/// - An arc has five points or more. Three or four points are an arc if they are the whole
///   sequence. They are also an arc if they turn by ten degrees and the chords before and behind
///   continue the arc tangentially. (Any four symmetric points are on a circle.)
/// - No arc turns by more than 75 degrees at a point.
std::vector<LineOrArc> find_lines_and_arcs(const std::vector<Vec3>& points);

// Cubic splines without zero end curvature.

/// Computes the slopes dx/du of the not-a-knot cubic spline through points x (one per row) over
/// ascending u.
///
/// The spline is C2, and its third derivative is continuous at the first and the last inner knot.
/// Cubics are reproduced; three points give a parabola, two a straight line. Unlike natural
/// splines, whose curvature vanishes at the ends, not-a-knot splines approximate the curvature of
/// the points there. Requires two points or more. O(points³), some microseconds for ten points.
Points not_a_knot_slopes(const std::vector<double>& u, const Points& x);

}  // namespace batten
