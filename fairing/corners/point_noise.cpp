// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/corners/point_noise.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/geometry.h"

namespace batten {
namespace {

// Weights of the divided difference over these parameters, up to a factor. Empty if two of them
// coincide.
std::vector<double> difference_weights(const std::vector<double>& t) {
  std::vector<double> weights;
  for (const double a : t) {
    double product = 1;
    for (const double b : t)
      if (a != b) product *= (a - b) / (t.back() - t.front());
    weights.push_back(1 / product);
  }
  const bool is_finite = std::all_of(weights.begin(), weights.end(),
                                     [](double weight) { return std::isfinite(weight); });
  return is_finite ? weights : std::vector<double>();
}

// Normalised sizes, perpendicular to the chord, of the differences of `m` points at all positions
// without a corner inside their stencil. `t`: parameters of the points; empty: even.
std::vector<double> differences(const std::vector<Vec3>& points, bool closed,
                                const std::vector<int>& corners, int m,
                                const std::vector<double>& t) {
  const int n = isize(points);
  std::vector<double> at(static_cast<size_t>(m));
  for (int k = 0; k < m; ++k) at[k] = k;
  const std::vector<double> even = difference_weights(at);
  std::vector<double> sizes;
  for (int i = 0; i < (closed ? n : n - m + 1); ++i) {
    const bool cornered = std::any_of(corners.begin(), corners.end(), [&](int c) {
      const int k = (c - i + n) % n;
      return k > 0 && k < m - 1;
    });
    if (cornered) continue;
    for (int k = 0; k < m && !t.empty(); ++k) at[k] = t[(i + k) % n] + (i + k < n ? 0 : t.back());
    const std::vector<double> weights = t.empty() ? even : difference_weights(at);
    if (weights.empty()) continue;
    double norm = 0;
    Vec3 d = Vec3::Zero();
    for (int k = 0; k < m; ++k) {
      d += weights[k] * (points[(i + k) % n] - points[i]);
      norm += weights[k] * weights[k];
    }
    // The chord extends beyond the stencil, because the chord of a few points would be noise
    // itself.
    constexpr int beyond = 3;
    const int first = closed ? i - beyond + n : std::max(i - beyond, 0),
              last = closed ? i + m - 1 + beyond : std::min(i + m - 1 + beyond, n - 1);
    const Vec3 along = (points[last % n] - points[first % n]).stableNormalized();
    sizes.push_back((d - d.dot(along) * along).norm() / std::sqrt(norm));
  }
  return sizes;
}

}  // namespace

double estimate_noise(const std::vector<Vec3>& points, bool closed, const std::vector<int>& corners,
                      const std::vector<double>& parameters) {
  constexpr int fewest_points = 11, fewest = 4;
  if (isize(points) < fewest_points) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (const int m : {4, 6, 8}) {
    if (m > 6 && parameters.empty()) break;
    std::vector<double> sizes = differences(points, closed, corners, m, parameters);
    if (isize(sizes) < fewest) continue;
    // Quantile of |Gaussian|. In short lists, corners that are not known yet affect up to half of
    // all positions.
    const bool is_long = sizes.size() > 40 || !corners.empty();
    const double fraction = is_long ? 0.5 : 0.1, quantile = is_long ? 0.6745 : 0.1257;
    const auto at = sizes.begin() + static_cast<long>(fraction * static_cast<double>(sizes.size()));
    std::nth_element(sizes.begin(), at, sizes.end());
    least = std::min(least, *at / quantile);
  }
  return std::isfinite(least) ? least : 0;
}

namespace {

// The first point of block b; for b = blocks, the number of points.
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
  std::vector<double> length{0}, middle;  // per block: path length, middle index
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

namespace {

constexpr int side = 3;                // neighbours on either side
constexpr double kOutlierScore = 4.5;  // score above which a point is an outlier, in standard
                                       // deviations
constexpr double kInlierScore = 4;     // largest score that the points near an outlier may keep

class OutlierSearch {
 public:
  OutlierSearch(const std::vector<Vec3>& points, bool closed)
      : points_(points), closed_(closed), count_(isize(points)), inlier_(points.size(), 1) {}

  std::vector<int> run() {
    std::vector<double> heights;
    find_noise();
    constexpr double least = 1e-9;
    const double size = bounding_box(points_).diagonal().norm();
    if (noise_ <= least * size || along_ <= least * size) return {};
    // If high-order differences do not see it, it is shape and not noise.
    constexpr double some = 0.3;
    if (estimate_noise(points_, closed_) < some * noise_) return {};
    for (int i = 0; i < count_; ++i) heights.push_back(outlier_score(i));
    std::vector<int> order;
    for (int i = 0; i < count_; ++i)
      if (heights[i] > kOutlierScore) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](int a, int b) { return heights[a] > heights[b]; });
    for (const int i : order)
      if (inlier_[i] && outlier_score(i) > kOutlierScore) reject_around(i);
    std::vector<int> outliers;
    for (int i = 0; i < count_; ++i)
      if (!inlier_[i]) outliers.push_back(i);
    constexpr int tenth = 10;
    if (isize(outliers) * tenth > count_) outliers.clear();
    return outliers;
  }

 private:
  int number(int i) const { return closed_ ? ((i % count_) + count_) % count_ : i; }
  bool has(int i) const { return closed_ || (i >= 0 && i < count_); }

  // From the medians of the residuals. The noise is isotropic across the curve, or it lies in the
  // plane of the curve.
  void find_noise() {
    std::vector<double> sizes, along;
    Mat3 spread = Mat3::Zero();
    for (int i = 0; i < count_; ++i) {
      const LineResidual off = line_residual(i);
      sizes.push_back(off.across.norm());
      along.push_back(off.along);
      if (sizes.back() > 0)
        spread += off.across * off.across.transpose() / off.across.squaredNorm();
    }
    const auto median = [&](std::vector<double>& values) {
      const auto middle = values.begin() + count_ / 2;
      std::nth_element(values.begin(), middle, values.end());
      return *middle;
    };
    // Medians of the norm of one and of two Gaussian variables.
    constexpr double in_plane = 0.6745, in_space = 1.1774, flat = 0.02;
    const Vec3 shares = symmetric_eigen(spread).values;
    const bool plane = shares[0] <= flat * shares.sum();
    noise_ = median(sizes) / (plane ? in_plane : in_space);
    along_ = median(along) / in_plane;
  }

  // In standard deviations. Residuals along the curve count less, because points may be spaced
  // unevenly.
  double outlier_score(int i) const {
    constexpr double less = 0.6;
    const LineResidual off = line_residual(i);
    return std::max(off.across.norm() / noise_, less * off.along / along_);
  }

  // Residual of point i from the least-squares parabola through the inliers around it, across the
  // curve and along it. It is normalised so that each coordinate has the standard deviation of the
  // noise. 0 beside an end.
  struct LineResidual {
    Vec3 across = Vec3::Zero();
    double along = 0;
  };
  LineResidual line_residual(int i) const {
    constexpr int farthest = 8;
    Eigen::Matrix<double, 2 * side, 3> powers;
    Eigen::Matrix<double, 2 * side, 3> near;
    int found = 0;
    for (const int side_sign : {-1, 1}) {
      const int before = found;
      for (int k = side_sign; std::abs(k) <= farthest && found < before + side; k += side_sign) {
        if (!has(i + k) || !inlier_[number(i + k)]) continue;
        powers.row(found) << 1, k, k * k;
        near.row(found++) = points_[number(i + k)];
      }
      constexpr int fewest = 2;
      if (found < before + fewest) return {};
    }
    const auto V = powers.topRows(found);
    const Mat3 normal = V.transpose() * V;
    const VecX weights = V * normal.inverse().col(0);
    Vec3 off = points_[i] - near.topRows(found).transpose() * weights;
    Vec3 along = Vec3::Zero();  // direction of the least-squares line
    for (int k = 0; k < found; ++k) along += powers(k, 1) * near.row(k).transpose();
    along -= powers.col(1).head(found).mean() * near.topRows(found).colwise().sum().transpose();
    along.stableNormalize();
    off /= std::sqrt(1 + weights.squaredNorm());
    const double part = off.dot(along);
    return {off - part * along, std::abs(part)};
  }

  // Inliers within `reach` positions around i.
  std::vector<int> inliers_around(int i, int reach) const {
    std::vector<int> near;
    for (int k = i - reach; k <= i + reach; ++k)
      if (has(k) && inlier_[number(k)]) near.push_back(number(k));
    return near;
  }

  // True if the curve turns at point i, around which points have been removed, by more than noise
  // explains. The turn is between the least-squares lines through five points on either side. The
  // removed points were then a corner.
  bool turns_at(int i) const {
    constexpr int arm = 5;
    constexpr double least_turn = 25, errors = 3;
    std::array<Vec3, 2> directions;
    double step = 0;
    for (const int side_sign : {-1, 1}) {
      Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
      double mean = 0;
      int found = 0;
      for (int k = side_sign; std::abs(k) <= 3 * arm && found < arm && has(i + k); k += side_sign) {
        if (!inlier_[number(i + k)]) continue;
        sum += points_[number(i + k)];
        moment += k * points_[number(i + k)];
        mean += k;
        ++found;
      }
      if (found < arm) return false;
      mean /= arm;
      Vec3& direction = directions[side_sign > 0];
      direction = moment - mean * sum;
      step += 0.5 * direction.norm() / (arm * (arm * arm - 1) / 12.0);
    }
    const double error = noise_ / step * std::sqrt(12 / (arm * (arm * arm - 1.0)));
    return degrees_between(directions[0], directions[1]) >
           least_turn + errors * error * 180 / std::numbers::pi;
  }

  // Rejects the smallest set of points around i, at most three, without which no point there stands
  // out.
  void reject_around(int i) {
    constexpr size_t most = 8;
    std::vector<int> near = inliers_around(i, 2 * side);
    const auto height = [&](int k) { return outlier_score(k); };
    std::sort(near.begin(), near.end(), [&](int a, int b) { return height(a) > height(b); });
    near.resize(std::min(near.size(), most));
    std::vector<std::vector<int>> sets;
    const size_t n = near.size();
    for (size_t a = 0; a < n; ++a) sets.push_back({near[a]});
    for (size_t a = 0; a < n; ++a)
      for (size_t b = a + 1; b < n; ++b) sets.push_back({near[a], near[b]});
    for (size_t a = 0; a < n; ++a)
      for (size_t b = a + 1; b < n; ++b)
        for (size_t c = b + 1; c < n; ++c) sets.push_back({near[a], near[b], near[c]});
    std::vector<int> best;
    double least = kInlierScore;
    for (const std::vector<int>& set : sets) {
      if (!best.empty() && set.size() > best.size()) break;
      for (const int k : set) inlier_[k] = 0;
      double highest = 0;
      for (const int k : inliers_around(i, side)) highest = std::max(highest, outlier_score(k));
      const bool all_out = std::all_of(set.begin(), set.end(), [&](int k) {
        return outlier_score(k) > kOutlierScore && !turns_at(k);
      });
      for (const int k : set) inlier_[k] = 1;
      if (!all_out || highest > least) continue;
      least = highest;
      best = set;
    }
    for (const int k : best) inlier_[k] = 0;
  }

  const std::vector<Vec3>& points_;
  bool closed_;
  int count_;
  std::vector<char> inlier_;
  double noise_ = 0, along_ = 0;  // standard deviations across and along the curve
};

}  // namespace

std::vector<int> find_outliers(const std::vector<Vec3>& points, bool closed) {
  constexpr int fewest = 20;
  return isize(points) < fewest ? std::vector<int>() : OutlierSearch(points, closed).run();
}

double largest_movement(double noise, double size) {
  constexpr double none = 1e-6;
  return 2 * noise + none * size;
}

}  // namespace batten
