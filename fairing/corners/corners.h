// SPDX-License-Identifier: MPL-2.0
// Corner detection in polylines: finds the points at which a sampled curve changes direction.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Finds the corners of a polyline.
///
/// Call find_corners() before fitting or fairing a curve, because fitted curves are C1 only between
/// corners.
///
/// `points`: samples in order, in any unit; points equal to the previous one are skipped. `closed`:
/// the polyline continues from its last point to its first; the first point must not be repeated at
/// the end. `angle`: smallest turning angle of a corner, degrees; 180 or more: no corners.
/// `block_size`: if it is above 1, corners are searched among means of that many consecutive
/// points; use it if the noise of neighbouring points is correlated.
///
/// Returns indices of `points`, ascending, without the end points of an open list.
///
/// The turning angle at a point is the angle between the chords before and behind it. A point with
/// a turning angle above `angle` is a corner if it **stands out** from its neighbours. Its turning
/// angle must be at least 2.2 times as large as those at the adjacent points. It must also exceed
/// the value extrapolated from them, which assumes that turning angles continue to grow at the same
/// rate, by a factor of at most 3 per point. An arc of five points, for example, has no corner
/// although it turns by 45 degrees at each point. Further rules:
///
/// - A turning angle above 75 degrees is always a corner, unless the angles grow towards it from
///   both sides, as at the nose of an airfoil.
/// - A turning angle above 40 degrees is a corner if one adjacent chord is 2.5 times as long as the
///   other. Squares and chamfers are typically given by such points.
/// - In lists of eleven points or fewer, a corner turns by at least 20 degrees and by three times
///   as much as its neighbours. It turns by at least 60 degrees if one side of it is a single
///   chord.
/// - Turning angles that grow steadily over four points up to the last chord, to at most 75
///   degrees, are half of a nose and not a corner.
///
/// A closed list that turns by 50 degrees or more at every point is a polygon: all of its points
/// are corners. (A circle therefore needs eight points, which turn by 45 degrees, or more.) All
/// inner points of a **zigzag** are corners, too: a list, or a run of three points or more in it,
/// that turns by more than 25 degrees at each point and changes its direction of turning at least
/// twice (stars, gears, zigzags); 20 degrees suffice for a list that turns left and right in turns.
///
/// If the points are so noisy that turns of `angle` could be noise, a likelihood test finds the
/// corners that turning angles do not show. It compares two polynomial arms that meet at the
/// candidate, straight or parabolic and of up to sixty points each, with single polynomials of up
/// to the fifth degree. The arms must fit significantly better. The noise is estimated from third
/// and fifth differences across the curve. At most about three hundred points are tested; longer
/// lists are replaced by means of neighbouring points.
///
/// Cost: O(points); with noise up to some tens of milliseconds.
std::vector<int> find_corners(const std::vector<Vec3>& points, bool closed, double angle,
                              int block_size = 1);

}  // namespace batten
