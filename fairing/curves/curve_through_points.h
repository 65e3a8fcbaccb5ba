// The curve through points, as a user gives them: lines, arcs, and splines between them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/input_curve.h"
#include "batten/core/eigen.h"

namespace batten {

/// A curve through points, in their order, C1 between corners. Between corners it is
///
/// - straight, or an arc, where points lie on a line or on a circle (find_lines_and_arcs()): exactly
///   straight, and off the circle by 4e-6 of the radius where points are 45 degrees apart (it grows
///   with the sixth power);
/// - elsewhere the C2 cubic spline over chord lengths. It begins and ends along lines and arcs; at
///   corners and ends its last piece is a parabola: three points give one unless they are an arc's.
///
/// Corners are the points of `corners` (numbers from 0), or found where it is not given: they turn by
/// `corner_angle` degrees at least and stand out, as find_corners() says.
///
/// A point list whose last point equals its first is closed, smooth across the seam too, unless
/// that is a corner. The slope is 1 where lines and arcs are. Throws InputError: fewer than two
/// points, a number that is not finite, two successive points that coincide (closer than 1e-9 of
/// the size), all points in one place, a stated corner that is not among the points. `name` is used
/// in messages. Cost: O(points), and what find_corners() takes.
std::shared_ptr<const InputCurve> curve_through_points(
    const std::string& name, const std::vector<Vec3>& points, double corner_angle = 20,
    const std::optional<std::vector<int>>& corners = {});


// Straight stretches and arcs among points that are given in an order. Internal.

/// Points first … last of a row that lie on a straight line or on a circular arc, and the unit
/// tangents there.
struct LineOrArc {
  int first = 0, last = 0;
  std::vector<Vec3> tangents;
};

/// The runs of an open row without corners, ascending; neighbours may share a point, at which they
/// have the same tangent then. Points are on a line or circle within 5e-5 of the run's chord.
///
/// Dense points of any smooth curve are nearly on lines and circles, and a spline through them is
/// better left alone. So a straight run turns at one of its ends by half a degree and twenty times
/// as much as inside (three points: a thousand times), and an arc bends the same (2 %) at all its
/// points, and by a fifth more or less at its ends.
///
/// Straight: three points or more, not three at an inflection, with turns of opposite sign before
/// and behind: symmetric curves have such. Arc: five points or more, or fewer, but three, if they
/// are the whole row or if they turn by ten degrees and the chord before and the one behind leave
/// along the arc: any four points that are symmetric are on a circle. No arc turns by more than 75 degrees at a point.
std::vector<LineOrArc> find_lines_and_arcs(const std::vector<Vec3>& points);


// Cubic splines whose ends are not flat.

/// Slopes dx/du of the C2 cubic spline through points x (rows) over ascending u whose third
/// derivative goes on across the first and the last inner knot ("not a knot"): cubics stay as they
/// are; three points make a parabola, two a straight line. Ends of natural splines have no
/// curvature, these have that of the points. Two points or more. O(points³), some microseconds for
/// ten.
Points not_a_knot_slopes(const std::vector<double>& u, const Points& x);

}  // namespace batten
