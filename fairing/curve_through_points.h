// The curve through points, as a user gives them: lines, arcs, and splines between them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/input_curve.h"

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

}  // namespace batten
