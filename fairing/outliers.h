// Points that are off their line farther than its noise explains. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Outliers among points given in an order, ascending; never an end of an open list, nothing in
/// lists of fewer than twenty points or without noise.
///
/// A point stands out by its distance from the parabola of least squares through three neighbours
/// on either side, in standard deviations of what all points have there across the line; along the
/// line 0.6 as much, because points may be spaced unevenly. An **outlier** stands out by more than
/// 4.5, and without it, or without two or three such points near each other, nobody near does by
/// more than 4, and the line does not turn there. So corners and tight bends have none. More than a tenth of all points are no
/// outliers. Cost: O(points).
std::vector<int> find_outliers(const std::vector<Vec3>& points, bool closed);

}  // namespace batten
