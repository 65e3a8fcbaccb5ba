// Means of neighbouring points, where steps from point to point are noise. Internal.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

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

}  // namespace batten
