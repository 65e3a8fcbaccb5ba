// Straight stretches and arcs among points that are given in an order. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

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

}  // namespace batten
