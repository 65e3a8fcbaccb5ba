#include "batten/fairing/outliers.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "batten/core/box.h"
#include "batten/core/dense.h"
#include "batten/core/format.h"
#include "batten/core/isize.h"
#include "batten/fairing/noise_estimate.h"

namespace batten {
namespace {

constexpr int side = 3;                // neighbours on either side
constexpr double kOutlierScore = 4.5;  // times the noise
constexpr double kInlierScore = 4;     // what points beside outliers may stand out by

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
    // What differences of high order do not see is shape.
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

  // From the medians of what is off the line: noise is the same in both directions across it, or
  // lies in the plane of the line.
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
    // Medians of the sizes of one and of two Gaussian numbers.
    constexpr double in_plane = 0.6745, in_space = 1.1774, flat = 0.02;
    const Vec3 shares = symmetric_eigen(spread).values;
    const bool plane = shares[0] <= flat * shares.sum();
    noise_ = median(sizes) / (plane ? in_plane : in_space);
    along_ = median(along) / in_plane;
  }

  // Times the noise. What is off along the line is less of a sign: points may be spaced unevenly.
  double outlier_score(int i) const {
    constexpr double less = 0.6;
    const LineResidual off = line_residual(i);
    return std::max(off.across.norm() / noise_, less * off.along / along_);
  }

  // From the parabola through the neighbours that are left to point i, across the line and along
  // it, over what noise makes of it: each coordinate has the standard deviation of the noise. 0
  // beside an end.
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
    Vec3 along = Vec3::Zero();  // of the straight line of least squares
    for (int k = 0; k < found; ++k) along += powers(k, 1) * near.row(k).transpose();
    along -= powers.col(1).head(found).mean() * near.topRows(found).colwise().sum().transpose();
    along.stableNormalize();
    off /= std::sqrt(1 + weights.squaredNorm());
    const double part = off.dot(along);
    return {off - part * along, std::abs(part)};
  }

  // Points that are left, so many places around i.
  std::vector<int> inliers_around(int i, int reach) const {
    std::vector<int> near;
    for (int k = i - reach; k <= i + reach; ++k)
      if (has(k) && inlier_[number(k)]) near.push_back(number(k));
    return near;
  }

  // Whether the line turns at place i, where some points have been taken out, by more than noise
  // lets the straight lines through five points on either side turn: what is out was a corner.
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

  // Takes the fewest points around i, three at most, without which nobody there stands out.
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
  double noise_ = 0, along_ = 0;  // standard deviations across the line, and along it
};

}  // namespace

std::vector<int> find_outliers(const std::vector<Vec3>& points, bool closed) {
  constexpr int fewest = 20;
  return isize(points) < fewest ? std::vector<int>() : OutlierSearch(points, closed).run();
}

}  // namespace batten
