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

}  // namespace batten
