// SPDX-License-Identifier: MPL-2.0
// Noise of sampled curves: its standard deviation, averages of neighbouring points, and outliers.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Estimates the standard deviation of the points across their curve, which is assumed to be smooth
/// between `corners` (ascending indices).
///
/// It uses third and fifth differences of the points, perpendicular to the chord below them, and
/// takes the smaller of both estimates. Each is a median, so that a few undetected corners do not
/// count as noise. Variation along the curve is not noise: the points may be spaced unevenly. Model
/// units; 0 for fewer than eleven points.
///
/// `parameters`: ascending parameters of the points, and if closed, the total. Divided differences
/// of up to seventh order then replace the differences, so that uneven spacing on a bend does not
/// count as noise. Empty: even parameters.
double estimate_noise(const std::vector<Vec3>& points, bool closed,
                      const std::vector<int>& corners = {},
                      const std::vector<double>& parameters = {});

/// Largest RMS distance by which fair_points() moves points, unless a noise, a deviation or a
/// wavelength is stated: twice their estimated noise, because larger distances cannot be noise,
/// plus 1e-6 of their size. Conditions and FairOptions::drawn_by_hand permit more.
double largest_movement(double noise, double size);

// Averages of neighbouring points, for samples whose steps from point to point are mostly noise.

/// True if the polyline through all points is much longer than the one through every fourth point.
/// Always false for fewer than 16 points.
bool is_zigzag(const std::vector<Vec3>& points);

/// Smallest block size for block_means() beyond which doubling the block hardly shortens the path.
///
/// It is 1 if steps from point to point are progress along the curve rather than noise. At least 16
/// means always remain. O(points log points).
int averaging_block_size(const std::vector<Vec3>& points);

/// Means of blocks of `each` consecutive points. If `each` does not divide the number of points,
/// some blocks are larger.
std::vector<Vec3> block_means(const std::vector<Vec3>& points, int each);

/// Arc length along block_means(), interpolated at each point and starting at 0 for the first.
///
/// Beyond the centres of the first and the last block it is extrapolated with the adjacent slope.
/// `closed`: one more entry, the total length.
std::vector<double> averaged_chord_length(const std::vector<Vec3>& points, int each, bool closed);

// Outliers: points farther from their curve than its noise explains.

/// Finds outliers among points given in order; their indices, ascending.
///
/// The end points of an open list are never outliers. The result is empty for lists of fewer than
/// twenty points and for points without noise.
///
/// The score of a point is its distance from the least-squares parabola through three neighbours on
/// either side. It is measured in standard deviations of the same residual over all points. Across
/// the curve it counts fully; along the curve it counts 0.6 times, because points may be spaced
/// unevenly.
///
/// An **outlier** has a score above 4.5. In addition, once it is removed (alone or with one or two
/// other outliers nearby), no point near it may keep a score above 4, and the curve may not turn
/// there. Corners and tight bends are therefore not outliers. If more than a tenth of all points
/// qualify, none is an outlier. Cost: O(points).
std::vector<int> find_outliers(const std::vector<Vec3>& points, bool closed);

}  // namespace batten
