#include "batten/fairing/noise_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/isize.h"

namespace batten {
namespace {

// Sizes, across the chord, of the differences with these weights at all places without a corner
// between their ends, over the weights' norm.
std::vector<double> differences(const std::vector<Vec3>& points, bool closed,
                                const std::vector<int>& corners,
                                const std::vector<double>& weights) {
  const int n = isize(points), m = isize(weights);
  double norm = 0;
  for (const double w : weights) norm += w * w;
  std::vector<double> sizes;
  for (int i = 0; i < (closed ? n : n - m + 1); ++i) {
    const bool cornered = std::any_of(corners.begin(), corners.end(), [&](int c) {
      const int k = (c - i + n) % n;
      return k > 0 && k < m - 1;
    });
    if (cornered) continue;
    Vec3 d = Vec3::Zero();
    for (int k = 0; k < m; ++k) d += weights[k] * points[(i + k) % n];
    // A chord of a few points would be noise itself.
    constexpr int beyond = 3;
    const int first = closed ? i - beyond + n : std::max(i - beyond, 0),
              last = closed ? i + m - 1 + beyond : std::min(i + m - 1 + beyond, n - 1);
    const Vec3 along = (points[last % n] - points[first % n]).stableNormalized();
    sizes.push_back((d - d.dot(along) * along).norm() / std::sqrt(norm));
  }
  return sizes;
}

}  // namespace

double estimate_noise(const std::vector<Vec3>& points, bool closed,
                      const std::vector<int>& corners) {
  constexpr int fewest_points = 11, fewest = 4;
  if (isize(points) < fewest_points) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<double>& weights :
       {std::vector<double>{1, -3, 3, -1}, std::vector<double>{1, -5, 10, -10, 5, -1}}) {
    std::vector<double> sizes = differences(points, closed, corners, weights);
    if (isize(sizes) < fewest) continue;
    // Of |Gaussian|. In short lists corners that are not known yet touch up to half of all places.
    const bool is_long = sizes.size() > 40 || !corners.empty();
    const double fraction = is_long ? 0.5 : 0.1, quantile = is_long ? 0.6745 : 0.1257;
    const auto at = sizes.begin() + static_cast<long>(fraction * static_cast<double>(sizes.size()));
    std::nth_element(sizes.begin(), at, sizes.end());
    least = std::min(least, *at / quantile);
  }
  return std::isfinite(least) ? least : 0;
}

}  // namespace batten
