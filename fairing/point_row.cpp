#include "batten/fairing/point_row.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/words.h"

namespace batten {
namespace {

constexpr size_t kFewestDifferences = 8;  // below it a corner would be half of the evidence

// Half the spread of neighbours about a straight line through them, from third differences (which a
// smooth curve does not have): robust against corners because it is a median.
double noise_of(const std::vector<Vec3>& p) {
  std::vector<double> size;
  for (size_t i = 3; i < p.size(); ++i)
    size.push_back((p[i] - 3 * p[i - 1] + 3 * p[i - 2] - p[i - 3]).norm());
  if (size.size() < kFewestDifferences) return 0;
  std::nth_element(size.begin(), size.begin() + size.size() / 2, size.end());
  // |Gaussian in three dimensions| has the median 1.54 σ; the weights' norm is √20.
  return size[size.size() / 2] / (1.54 * std::sqrt(20.0));
}

// Direction of the `reach` points behind or before point i, with it: their regression on the
// number. Points nearer than `least` to the first say nothing about it and come on top.
Vec3 direction(const std::vector<Vec3>& p, bool closed, int i, int step, int reach, double least) {
  const int n = count_of(p);
  const int most = closed ? n - 1 : step > 0 ? n - 1 - i : i;
  const auto at = [&](int k) { return p[(i + (closed ? n : 0) + step * k) % n]; };
  reach = std::min(reach, most);
  while (reach < most && (at(reach) - p[i]).norm() < least) ++reach;
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k <= reach; ++k) sum += (k - 0.5 * reach) * at(k);
  return step * sum;
}

}  // namespace

std::vector<int> find_corners(const std::vector<Vec3>& points, bool closed, double angle) {
  const int n = count_of(points);
  if (n < 3 || angle >= 180) return {};
  // Progress from point to point, over so many of them that noise does not lengthen it.
  const int stride = std::max(n / 16, 1);
  std::vector<double> steps;
  for (int i = stride; i < n; ++i)
    steps.push_back((points[i] - points[i - stride]).norm() / stride);
  std::nth_element(steps.begin(), steps.begin() + steps.size() / 2, steps.end());
  const double spacing = steps[steps.size() / 2];
  // The direction of an arm of k points errs by about σ √12 / (k^1.5 spacing) radians: twelve of
  // that, for both arms of thousands of points, stay below a quarter of the angle.
  const double quarter = angle / 4 * std::numbers::pi / 180;
  const double needed =
      spacing > 0 ? std::pow(12 * std::sqrt(12.0) * noise_of(points) / (spacing * quarter), 2 / 3.0)
                  : 1;
  if (needed > n / 8.0 + 1) return {};  // so noisy that no corner can be told
  const int reach = std::max(1, static_cast<int>(needed));

  // A bend turns less between shorter arms, a corner as much.
  const auto turn_at = [&](int i, int arm) {
    constexpr double a_part = 0.05;  // of the spacing
    return degrees_between(direction(points, closed, i, -1, arm, a_part * spacing),
                           direction(points, closed, i, 1, arm, a_part * spacing));
  };
  std::vector<double> turn(n, 0.0);
  for (int i = closed ? 0 : reach; i < (closed ? n : n - reach); ++i) {
    turn[i] = turn_at(i, reach);
    if (turn[i] > angle && reach > 3 && turn_at(i, reach / 2) < 0.8 * turn[i]) turn[i] = 0;
  }
  std::vector<int> corners;
  for (int i = 0; i < n; ++i) {
    // The sharpest within an arm; of equal ones the first.
    bool sharpest = turn[i] > angle;
    for (int k = 1; k < reach && sharpest; ++k)
      for (const int step : {-k, k}) {
        const int other = closed ? (i + step + n) % n : i + step;
        if (other >= 0 && other < n && other != i)
          sharpest = sharpest && (turn[other] < turn[i] || (turn[other] == turn[i] && step > 0));
      }
    // Where the noise cannot be told, a corner has to stand alone and be half as sharp again: a
    // wave of five points has none.
    const bool few = points.size() < kFewestDifferences + 3;
    sharpest = sharpest && (!few || turn[i] > std::min(1.5 * angle, 180.0));
    if (sharpest && few)
      for (const int step : {-1, 1}) {
        const int other = closed ? (i + step + n) % n : i + step;
        sharpest = sharpest && (other < 0 || other >= n || turn[other] < 0.5 * turn[i]);
      }
    // Points that all but repeat the last corner are that corner.
    if (sharpest && !corners.empty())
      sharpest = (points[i] - points[corners.back()]).norm() > 0.05 * spacing;
    if (sharpest) corners.push_back(i);
  }
  return corners;
}

void check_tolerance(const std::string& name, double tolerance) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InputError("line '" + name + "': found the tolerance " + number(tolerance) +
                     ", expected a length above 0");
}

PointRow::PointRow(const std::string& name, const std::vector<Vec3>& given, double corner_angle,
                   const std::optional<std::vector<int>>& given_corners,
                   std::optional<bool> is_closed) {
  const std::string line = "line '" + name + "'";
  for (size_t i = 0; i < given.size(); ++i)
    if (!given[i].allFinite() || given[i].cwiseAbs().maxCoeff() > 1e100)
      throw InputError(line + ", point " + std::to_string(i + 1) +
                       ": a coordinate is not a finite number below 1e100");
  if (given.size() < 2)
    throw InputError(line + " has " + std::to_string(given.size()) + " point" +
                     (given.size() == 1 ? "" : "s") + ": it needs two or more");
  if (!(corner_angle > 0) || corner_angle > 180)
    throw InputError(line + ": found the corner angle " + number(corner_angle) +
                     ", expected one above 0, up to 180 degrees");
  size = box_around(given).diagonal().norm();
  if (!(size > 0)) throw InputError(line + " has zero length: all points are the same");
  // Points nearer than parameters can be told apart are one.
  double way = 0;
  for (size_t i = 1; i < given.size(); ++i) way += (given[i] - given[i - 1]).norm();
  const double same = std::max(1e-12 * size, 4e-9 * way);
  for (const Vec3& p : given) {
    if (points.empty() || (p - points.back()).norm() > same) points.push_back(p);
    index.push_back(count() - 1);
  }
  const bool comes_back = (count() > 3 || is_closed.value_or(false)) && count() > 1 &&
                          (points.back() - points.front()).norm() <= same;
  closed = is_closed.value_or(comes_back);
  if (closed && comes_back) {
    points.pop_back();
    for (int& i : index)
      if (i == count()) i = 0;
  }
  if (closed && count() < 3)
    throw InputError(line + " is closed and has " + std::to_string(count()) +
                     " different points: it needs three or more");
  chord = {0};
  for (int i = 1; i < count(); ++i)
    chord.push_back(chord.back() + (points[i] - points[i - 1]).norm());
  if (closed) chord.push_back(chord.back() + (points.front() - points.back()).norm());

  if (given_corners) {
    for (const int c : *given_corners) {
      if (c < 0 || c >= count_of(given))
        throw InputError(line + ": corner at point " + std::to_string(c + 1) + " of " +
                         std::to_string(given.size()));
      corners.push_back(index[c]);
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    if (!closed) std::erase_if(corners, [&](int c) { return c == 0 || c == count() - 1; });
  } else {
    corners = find_corners(points, closed, corner_angle);
  }
}

std::vector<double> PointRow::denoised_chord() const {
  constexpr int most_blocks = 200;
  const int n = count();
  if (n < 2 * most_blocks || noise_of(points) < 0.3 * length() / n) return chord;
  std::vector<Vec3> mean(most_blocks, Vec3::Zero());
  std::vector<double> middle(most_blocks);  // number of the block's middle point
  for (int b = 0; b < most_blocks; ++b) {
    const long from = static_cast<long>(b) * n / most_blocks,
               to = static_cast<long>(b + 1) * n / most_blocks;
    for (long i = from; i < to; ++i) mean[b] += points[i] / static_cast<double>(to - from);
    middle[b] = 0.5 * static_cast<double>(from + to - 1);
  }
  // Lengths between the means; the halves of the first and the last block go on as fast.
  std::vector<double> result;
  int b = 0;
  double before = 0;
  for (int i = 0; i < n + closed; ++i) {
    while (b + 2 < most_blocks && i > middle[b + 1]) {
      before += (mean[b + 1] - mean[b]).norm();
      ++b;
    }
    result.push_back(before + (mean[b + 1] - mean[b]).norm() * (i - middle[b]) /
                                  (middle[b + 1] - middle[b]));
  }
  const double first = result.front();
  for (double& u : result) u -= first;
  return result;
}

double PointRow::bend(int i) const {
  const int n = count();
  if (!closed && (i == 0 || i == n - 1)) return 0;
  const Vec3 &a = points[(i + n - 1) % n], &b = points[i], &c = points[(i + 1) % n];
  const double sides = (b - a).norm() * (c - b).norm() * (c - a).norm();
  return sides > 0 ? 2 * (b - a).cross(c - b).norm() / sides : 0;
}

double allowed_rise(double chord, double bend) {
  constexpr double generous = 1.5;
  const double half = std::min(0.5 * chord * bend, 1.0);  // sine of half the arc's angle
  return bend > 0 ? generous * half * half / (1 + std::sqrt(1 - half * half)) / bend : 0;
}

double beyond_chord(const Vec3& x, const Vec3& a, const Vec3& b, double rise) {
  const Vec3 chord = b - a;
  const double s = std::clamp((x - a).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
  return std::max(0.0, (x - a - s * chord).norm() - rise);
}

Deviation deviation_of(const HermiteCurve& curve, const PointRow& row,
                       const std::vector<double>& t) {
  Deviation d;
  double sum = 0;
  const int n = row.count();
  for (int i = 0; i < n; ++i) {
    const double off = (curve.evaluate(t[i]) - row.points[i]).norm();
    d.max = std::max(d.max, off);
    sum += off * off;
  }
  d.rms = std::sqrt(sum / n);
  const double period = curve.end() - curve.start();
  double bend = row.bend(0);
  for (int i = 0; i < (row.closed ? n : n - 1); ++i) {
    const int j = (i + 1) % n;
    const Vec3 &a = row.points[i], &b = row.points[j];
    const double before = std::exchange(bend, row.bend(j));
    const double rise = allowed_rise((b - a).norm(), std::max(before, bend));
    const double gap = t[j] - t[i] + (j == 0 ? period : 0);
    for (int k = 1; k < places_in_gap; ++k)
      d.between = std::max(
          d.between, beyond_chord(curve.evaluate(t[i] + gap * k / places_in_gap), a, b, rise));
  }
  return d;
}

}  // namespace batten
