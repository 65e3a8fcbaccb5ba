// The best similarity between two shapes of the same points.
#pragma once

#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// x → scale · R x + shift.
struct Similarity {
  double scale = 1;
  Mat3 R = Mat3::Identity();
  Vec3 translation = Vec3::Zero();
  double max_error = 0;  ///< largest distance left, over the size (box diagonal) of the first shape
};

/// Least-squares similarity from `before` to `after` on the given vertices, det R = +1. The scale
/// is fitted unless given. Source: Umeyama 1991. For points on one line R is the
/// smallest of the rotations that fit. O(vertices).
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices);
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale);
/// `weights`: one for each of the vertices, at least 0, not all of them 0.
Similarity fit_similarity(const Points& before, const Points& after,
                          const std::vector<int>& vertices, double scale,
                          const std::vector<double>& weights);

}  // namespace batten
