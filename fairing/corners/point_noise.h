// How noisy the points of a line are. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Standard deviation of points across their line, which is taken for a smooth one between
/// `corners` (ascending): from third and fifth differences across the chord below them, the lesser
/// of the two, by their median, so that a few more corners make no noise. What varies along the
/// line is no noise: points may be spaced as they like. 0 for fewer than eleven points.
double estimate_noise(const std::vector<Vec3>& points, bool closed,
                      const std::vector<int>& corners = {});


// Means of neighbouring points, where steps from point to point are noise. Internal.

/// Whether the way from point to point is much longer than that from every fourth to the next.
bool is_zigzag(const std::vector<Vec3>& points);

/// Of how many points means have to be so that those of twice as many make no much shorter way: 1
/// where steps are progress. Never so many that fewer than 16 means are left. O(points log points).
int averaging_block_size(const std::vector<Vec3>& points);

/// Means of blocks of so many points each; what is left over widens the blocks.
std::vector<Vec3> block_means(const std::vector<Vec3>& points, int each);

/// The way along means of so many points, at each point, from the first: the halves of the first and
/// the last block go on as fast as beside them. `closed`: one more entry, the whole.
std::vector<double> averaged_chord_length(const std::vector<Vec3>& points, int each, bool closed);


// Points that are off their line farther than its noise explains. Internal.

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
