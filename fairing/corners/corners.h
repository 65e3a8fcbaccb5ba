// Corners of lines that are given by points.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Points at which a line turns a corner, ascending, the ends of an open list not among them.
/// `closed`: the list goes on from its last point to its first, which it does not repeat.
///
/// A corner **stands out**: its turn, by more than `angle` degrees, is at least 2.2 times as large
/// as the turns beside it, and more than these would be there if they went on growing as they do,
/// up to threefold from point to point. So an arc of five points has none, though it turns by 45
/// degrees at each. A turn of more than 75 degrees is one in any case, unless the turns grow towards
/// it from both sides as towards the nose of a wing, and so is one of more than 40 where one side is
/// 2.5 times as long as the other: squares and chamfers are given by their corners. In lists of
/// eleven points or fewer a corner turns by 20 degrees at least, is three times as large, and turns
/// by 60 where one side of it is a single chord. In longer lists turns that grow steadily over four
/// points up to the last chord, to 75 degrees, are half of a nose and no corner.
///
/// A closed list that turns by 50 degrees or more at every point is a polygon: all of its points are
/// corners (a circle is given by eight points, which turn by 45, or more).
///
/// Where points are noisy, so that `angle` could be noise, arms of up to sixty points tell on either side:
/// two parabolas that meet at a corner have to be nearer to the points than any one polynomial, up
/// to the fifth degree, by more than chance would let them. The noise is estimated from third and
/// fifth differences across the line. At most about three hundred points are looked at then: means
/// of neighbours stand for more.
///
/// `block_size`: of so many points means tell corners, where neighbours are known to share their noise.
///
/// Cost: O(points); with noise up to some tens of milliseconds.
std::vector<int> find_corners(const std::vector<Vec3>& points, bool closed, double angle,
                              int block_size = 1);

}  // namespace batten
