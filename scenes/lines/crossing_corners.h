// SPDX-License-Identifier: MPL-2.0
// Corners at points where other curves end or pass.
#pragma once

#include <vector>

#include "batten/scenes/lines/source_line.h"

namespace batten {

/// Finds corners at points where another curve ends or passes, such as the chine in the stations of
/// a hard-chine hull, and adds them to SourceLine::crossing_corners.
///
/// Only curves through points whose corners are not given are changed. The candidates are points
/// within 1e-4 of the size of all curves from another curve, at which the turning angle is at least
/// 20 degrees and twice as large as at the points beside it. A candidate is a corner if
/// find_corners() has found one there. Beside an end of its curve, where find_corners() demands
/// more, it is also a corner if it turns by at least 45 degrees and by three times as much as the
/// point on its other side. If at least half of the candidates on one curve are corners, a crease
/// runs along that curve, and all of them are corners.
///
/// `corner_angle`: see find_corners(). Cost: O(points · curves) distances to sampled curves.
void find_crossing_corners(std::vector<SourceLine>& lines, double corner_angle);

}  // namespace batten
