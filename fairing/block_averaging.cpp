#include "batten/fairing/block_averaging.h"

#include <algorithm>

#include "batten/core/isize.h"

namespace batten {
namespace {

// The first point of block b, and behind the last block the number of points.
long first_of(long b, long blocks, long points) { return b * points / blocks; }

double path_length(const std::vector<Vec3>& points, int apart) {
  double sum = 0;
  for (int i = apart; i < isize(points); i += apart) sum += (points[i] - points[i - apart]).norm();
  return sum;
}

}  // namespace

bool is_zigzag(const std::vector<Vec3>& points) {
  constexpr int apart = 4, fewest = 16;
  constexpr double much_shorter = 0.7;
  return isize(points) >= fewest &&
         path_length(points, apart) < much_shorter * path_length(points, 1);
}

std::vector<Vec3> block_means(const std::vector<Vec3>& points, int each) {
  const long n = isize(points), blocks = n / each;
  std::vector<Vec3> result(static_cast<size_t>(blocks), Vec3::Zero());
  for (long b = 0; b < blocks; ++b) {
    const long from = first_of(b, blocks, n), to = first_of(b + 1, blocks, n);
    for (long i = from; i < to; ++i) result[b] += points[i] / static_cast<double>(to - from);
  }
  return result;
}

std::vector<double> averaged_chord_length(const std::vector<Vec3>& points, int each, bool closed) {
  const long n = isize(points), blocks = n / each;
  const std::vector<Vec3> mean = block_means(points, each);
  std::vector<double> length{0}, middle;  // at each mean: the way, the number of its middle point
  for (long b = 0; b < blocks; ++b) {
    if (b > 0) length.push_back(length.back() + (mean[b] - mean[b - 1]).norm());
    middle.push_back(0.5 *
                     static_cast<double>(first_of(b, blocks, n) + first_of(b + 1, blocks, n) - 1));
  }
  std::vector<double> result;
  for (long i = 0; i < n + closed; ++i) {
    const auto above = std::upper_bound(middle.begin() + 1, middle.end() - 1, i);
    const auto b = static_cast<size_t>(above - middle.begin());
    result.push_back(length[b - 1] + (length[b] - length[b - 1]) *
                                         (static_cast<double>(i) - middle[b - 1]) /
                                         (middle[b] - middle[b - 1]));
  }
  const double first = result.front();
  for (double& u : result) u -= first;
  return result;
}

int averaging_block_size(const std::vector<Vec3>& points) {
  constexpr int fewest_means = 16;
  constexpr double shorter = 1.15;
  int each = 1;
  double before = path_length(points, 1);
  for (int m = 2; isize(points) / m >= fewest_means; m *= 2) {
    const double now = averaged_chord_length(points, m, false).back();
    if (before > shorter * now) each = m;
    before = now;
  }
  return each;
}

}  // namespace batten
