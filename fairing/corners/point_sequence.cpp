// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/corners/point_sequence.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/corners.h"
#include "batten/fairing/corners/point_noise.h"

namespace batten {

void check_tolerance(const std::string& name, double tolerance) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InputError("curve '" + name + "': found the tolerance " + format_number(tolerance) +
                     ", expected a length above 0");
}

PointSequence::PointSequence(const std::string& name, const std::vector<Vec3>& given,
                             double corner_angle,
                             const std::optional<std::vector<int>>& given_corners,
                             std::optional<bool> is_closed, Outliers outliers,
                             const NoiseLevel& known) {
  const std::string line = "curve '" + name + "'";
  for (size_t i = 0; i < given.size(); ++i)
    if (!given[i].allFinite() || given[i].cwiseAbs().maxCoeff() > 1e100)
      throw InputError(line + ", point " + std::to_string(i + 1) +
                       ": a coordinate is not a finite number below 1e100");
  if (given.size() < 2)
    throw InputError(line + " has " + std::to_string(given.size()) + " point" +
                     (given.size() == 1 ? "" : "s") + ", expected two or more");
  if (!(corner_angle > 0) || corner_angle > 180)
    throw InputError(line + ": found the corner angle " + format_number(corner_angle) +
                     ", expected degrees above 0, up to 180");
  size = bounding_box(given).diagonal().norm();
  if (!(size > 0)) throw InputError(line + " has zero length: all points coincide");
  // Points closer than parameters can be distinguished count as one.
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
                     " distinct points, expected three or more");
  if (outliers == Outliers::Drop) reject_outliers(given_corners);
  chord = {0};
  for (int i = 1; i < count(); ++i)
    chord.push_back(chord.back() + (points[i] - points[i - 1]).norm());
  if (closed) chord.push_back(chord.back() + (points.front() - points.back()).norm());

  if (given_corners) {
    for (const int c : *given_corners) {
      if (c < 0 || c >= isize(given))
        throw InputError(line + ": found a corner at point " + std::to_string(c + 1) +
                         ", expected 1 to " + std::to_string(given.size()));
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

// Block size whose means are free of correlated noise (tremor).
int PointSequence::block_size(const NoiseLevel& known) const {
  constexpr double more = 1.6, waves = 4;
  if (!(known.size > more * estimate_noise(points, closed)) && !(known.wavelength > 0)) return 1;
  const int each = averaging_block_size(points);
  if (known.size > 0) return each;
  const double apart = averaged_chord_length(points, each, closed).back() / count();
  return std::max(1, static_cast<int>(std::min<double>(each, known.wavelength / waves / apart)));
}

std::vector<double> PointSequence::averaged_chord() const {
  constexpr double much = 0.3;  // fraction of a step
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
  const double half = std::min(0.5 * chord * curvature, 1.0);  // sine of half of the arc's angle
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

namespace {

// Mean gap of the parameters around index i.
double gap_around(const std::vector<double>& places, size_t i) {
  constexpr size_t reach = 4;
  const size_t from = i < reach ? 0 : i - reach, to = std::min(i + reach, places.size() - 1);
  return (places[to] - places[from]) / static_cast<double>(std::max<size_t>(to - from, 1));
}

// Merges the forced nodes with those of the wanted ones that are farther from others than a
// fraction of the gaps around them; both ascending. Foot points that noise pushes together would
// give nodes so close that curvature changes between them lose their digits.
std::vector<double> merged_nodes(const std::vector<double>& nodes,
                                 const std::vector<double>& wanted, double fraction, double least) {
  std::vector<double> merged;
  size_t next = 0;
  for (size_t k = 0; k + 1 < nodes.size(); ++k) {
    merged.push_back(nodes[k]);
    for (; next < wanted.size(); ++next) {
      const double gap = std::max(least, fraction * gap_around(wanted, next));
      if (wanted[next] >= nodes[k + 1] - gap) break;
      if (wanted[next] >= merged.back() + gap) merged.push_back(wanted[next]);
    }
  }
  merged.push_back(nodes.back());
  return merged;
}

std::vector<double> with_middles(const std::vector<double>& nodes) {
  std::vector<double> all;
  for (size_t k = 0; k + 1 < nodes.size(); ++k) {
    all.push_back(nodes[k]);
    all.push_back(0.5 * (nodes[k] + nodes[k + 1]));
  }
  all.push_back(nodes.back());
  return all;
}

// All nodes. If mirrored, the second half has the mirror images of those of the first.
std::vector<double> all_nodes(const PointSequence& sequence, const std::vector<double>& u,
                              double length, std::vector<double> forced, bool mirrored,
                              int max_knots) {
  std::vector<double> places = u, wanted;
  std::sort(places.begin(), places.end());
  const size_t stride =
      (places.size() + static_cast<size_t>(max_knots) - 1) / static_cast<size_t>(max_knots);
  for (size_t i = 0; i < places.size(); i += stride) wanted.push_back(places[i]);
  const double end = mirrored ? 0.5 * length : length;
  if (mirrored)
    for (auto* all : {&forced, &wanted})
      for (double& at : *all) at = std::min(at, length - at);
  forced.push_back(end);
  constexpr int few = 11;  // with fewer points, all are interpolated, or nearly
  // The forced nodes first, then those of the others that are not too close to them. (What acts
  // between nodes acts there too; a corner and the mirror image of its partner are one.)
  const double spacing = length / std::min(sequence.count(), max_knots);
  // Corners and their mirror images need more distance.
  const double same = (mirrored ? 1 : 2e-4) * spacing;
  std::sort(forced.begin(), forced.end());
  std::vector<double> nodes;
  for (const double at : forced)
    if (nodes.empty() || at - nodes.back() > same) nodes.push_back(at);
  nodes.back() = end;
  std::sort(wanted.begin(), wanted.end());
  std::vector<double> merged =
      merged_nodes(nodes, wanted, sequence.count() < few && !mirrored ? 0.02 : 0.3, 2e-4 * spacing);
  if (max_knots > sequence.count()) merged = with_middles(merged);
  // A closed curve needs at least three segments: the longest ones are halved.
  while (sequence.closed && merged.size() < 4) {
    size_t longest = 0;
    for (size_t k = 0; k + 1 < merged.size(); ++k)
      if (merged[k + 1] - merged[k] > merged[longest + 1] - merged[longest]) longest = k;
    merged.insert(merged.begin() + static_cast<long>(longest) + 1,
                  0.5 * (merged[longest] + merged[longest + 1]));
  }
  std::vector<double> parameters = merged;
  if (mirrored)
    for (size_t k = merged.size() - 1; k-- > 0;) parameters.push_back(length - merged[k]);
  return parameters;
}

}  // namespace

KnotPlacement place_knots(const PointSequence& sequence, const std::vector<double>& u,
                          double length, std::vector<double> forced, bool mirrored, int max_knots) {
  std::vector<double> parameters =
      all_nodes(sequence, u, length, std::move(forced), mirrored, max_knots);
  const auto nearest = [&](double at) {
    const auto above = std::lower_bound(parameters.begin(), parameters.end(), at);
    if (above == parameters.end()) return isize(parameters) - 1;
    const auto i = above - parameters.begin();
    return static_cast<int>(i > 0 && at - parameters[i - 1] < *above - at ? i - 1 : i);
  };
  const int last = isize(parameters) - 1;
  std::vector<int> corners;
  for (const int c : sequence.corners) {
    const int node = nearest(u[c]);
    if (!sequence.closed && (node == 0 || node == last)) continue;
    corners.push_back(node % (sequence.closed ? last : last + 1));
    if (mirrored) corners.push_back((last - node) % (sequence.closed ? last : last + 1));
  }
  std::vector<int> corner_node;
  for (const int c : sequence.corners)
    corner_node.push_back(nearest(u[c]) % (sequence.closed ? last : last + 1));
  return {CurveMesh(std::move(parameters), sequence.closed, std::move(corners)),
          std::move(corner_node)};
}

}  // namespace batten
