#include "batten/fairing/point_sequence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/format.h"
#include "batten/fairing/block_averaging.h"
#include "batten/fairing/corners.h"
#include "batten/fairing/noise_estimate.h"
#include "batten/fairing/outliers.h"

namespace batten {

void check_tolerance(const std::string& name, double tolerance) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InputError("line '" + name + "': found the tolerance " + format_number(tolerance) +
                     ", expected a length above 0");
}

PointSequence::PointSequence(const std::string& name, const std::vector<Vec3>& given,
                             double corner_angle,
                             const std::optional<std::vector<int>>& given_corners,
                             std::optional<bool> is_closed, Outliers outliers,
                             const NoiseLevel& known) {
  const std::string line = "line '" + name + "'";
  for (size_t i = 0; i < given.size(); ++i)
    if (!given[i].allFinite() || given[i].cwiseAbs().maxCoeff() > 1e100)
      throw InputError(line + ", point " + std::to_string(i + 1) +
                       ": a coordinate is not a finite number below 1e100");
  if (given.size() < 2)
    throw InputError(line + " has " + std::to_string(given.size()) + " point" +
                     (given.size() == 1 ? "" : "s") + ": it needs two or more");
  if (!(corner_angle > 0) || corner_angle > 180)
    throw InputError(line + ": found the corner angle " + format_number(corner_angle) +
                     ", expected one above 0, up to 180 degrees");
  size = bounding_box(given).diagonal().norm();
  if (!(size > 0)) throw InputError(line + " has zero length: all points are the same");
  // Points nearer than parameters can be told apart are one.
  double path_length = 0;
  for (size_t i = 1; i < given.size(); ++i) path_length += (given[i] - given[i - 1]).norm();
  const double same = std::max(1e-12 * size, 4e-9 * path_length);
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
  if (outliers == Outliers::Drop) reject_outliers(given_corners);
  chord = {0};
  for (int i = 1; i < count(); ++i)
    chord.push_back(chord.back() + (points[i] - points[i - 1]).norm());
  if (closed) chord.push_back(chord.back() + (points.front() - points.back()).norm());

  if (given_corners) {
    for (const int c : *given_corners) {
      if (c < 0 || c >= isize(given))
        throw InputError(line + ": corner at point " + std::to_string(c + 1) + " of " +
                         std::to_string(given.size()));
      corners.push_back(index[c]);
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    if (!closed) std::erase_if(corners, [&](int c) { return c == 0 || c == count() - 1; });
  } else {
    corners = find_corners(points, closed, corner_angle, block_size(known));
  }
}

void PointSequence::reject_outliers(const std::optional<std::vector<int>>& given_corners) {
  std::vector<int> off = find_outliers(points, closed);
  if (given_corners)
    for (const int c : *given_corners) std::erase(off, index[c]);
  if (off.empty()) return;
  std::vector<int> place(points.size(), -1);
  std::vector<Vec3> kept;
  for (int i = 0; i < count(); ++i) {
    if (std::binary_search(off.begin(), off.end(), i)) continue;
    place[i] = isize(kept);
    kept.push_back(points[i]);
  }
  for (int& i : index) i = place[i];
  points = std::move(kept);
}

// Of so many points means are free of the tremor.
int PointSequence::block_size(const NoiseLevel& known) const {
  constexpr double more = 1.6, waves = 4;
  if (!(known.size > more * estimate_noise(points, closed)) && !(known.wavelength > 0)) return 1;
  const int each = averaging_block_size(points);
  if (known.size > 0) return each;
  const double apart = averaged_chord_length(points, each, closed).back() / count();
  return std::max(1, static_cast<int>(std::min<double>(each, known.wavelength / waves / apart)));
}

std::vector<double> PointSequence::averaged_chord() const {
  constexpr double much = 0.3;  // of a step
  if (estimate_noise(points, closed) < much * length() / count() && !is_zigzag(points))
    return chord;
  const int each = averaging_block_size(points);
  return each > 1 ? averaged_chord_length(points, each, closed) : chord;
}

double PointSequence::curvature(int i) const {
  const int n = count();
  if (!closed && (i == 0 || i == n - 1)) return 0;
  const Vec3 &a = points[(i + n - 1) % n], &b = points[i], &c = points[(i + 1) % n];
  const double sides = (b - a).norm() * (c - b).norm() * (c - a).norm();
  return sides > 0 ? 2 * (b - a).cross(c - b).norm() / sides : 0;
}

double sagitta_bound(double chord, double curvature) {
  constexpr double generous = 1.5;
  const double half = std::min(0.5 * chord * curvature, 1.0);  // sine of half the arc's angle
  return curvature > 0 ? generous * half * half / (1 + std::sqrt(1 - half * half)) / curvature : 0;
}

double chord_excess(const Vec3& x, const Vec3& a, const Vec3& b, double sagitta) {
  const Vec3 chord = b - a;
  const double s = std::clamp((x - a).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
  return std::max(0.0, (x - a - s * chord).norm() - sagitta);
}

Deviation deviation_of(const HermiteCurve& curve, const PointSequence& row,
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
  double curvature = row.curvature(0);
  for (int i = 0; i < (row.closed ? n : n - 1); ++i) {
    const int j = (i + 1) % n;
    const Vec3 &a = row.points[i], &b = row.points[j];
    const double before = std::exchange(curvature, row.curvature(j));
    const double sagitta = sagitta_bound((b - a).norm(), std::max(before, curvature));
    const double gap = t[j] - t[i] + (j == 0 ? period : 0);
    for (int k = 1; k < kSamplesPerGap; ++k)
      d.between = std::max(
          d.between, chord_excess(curve.evaluate(t[i] + gap * k / kSamplesPerGap), a, b, sagitta));
  }
  return d;
}

}  // namespace batten
