// Cubic splines whose ends are not flat.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Slopes dx/du of the C2 cubic spline through points x (rows) over ascending u whose third
/// derivative goes on across the first and the last inner knot ("not a knot"): cubics stay as they
/// are; three points make a parabola, two a straight line. Ends of natural splines have no
/// curvature, these have that of the points. Two points or more. O(points³), some microseconds for
/// ten.
Points not_a_knot_slopes(const std::vector<double>& u, const Points& x);

}  // namespace batten
