// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/driving_curve.h"

#include <algorithm>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/scene/scene.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/lines/scene_lines.h"

namespace batten {
namespace {

/// Cumulative lengths of a polyline, relative to the whole length.
std::vector<double> length_shares(const std::vector<Vec3>& points) {
  std::vector<double> shares{0};
  for (size_t i = 1; i < points.size(); ++i)
    shares.push_back(shares.back() + (points[i] - points[i - 1]).norm());
  if (!(shares.back() > 0)) throw InputError("found a curve without length");
  for (double& share : shares) share /= shares.back();
  return shares;
}

/// The point of a polyline at a share of its length, 0 to 1.
Vec3 point_at(const std::vector<Vec3>& points, const std::vector<double>& shares, double share) {
  const auto next = std::upper_bound(shares.begin() + 1, shares.end() - 1, share);
  const auto k = static_cast<size_t>(next - shares.begin());
  const double step = shares[k] - shares[k - 1];
  return points[k - 1] +
         (step > 0 ? (share - shares[k - 1]) / step : 0) * (points[k] - points[k - 1]);
}

/// Points at given shares of a curve, from a start, in one direction.
std::vector<Vec3> candidate(const std::vector<Vec3>& samples, const std::vector<double>& along,
                            const std::vector<double>& shares, double start, bool forward) {
  std::vector<Vec3> points;
  for (const double share : shares) {
    double at = start + (forward ? share : -share);
    if (at < 0) at += 1;
    if (at > 1) at -= 1;
    points.push_back(point_at(samples, along, at));
  }
  return points;
}

double squared_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return sum;
}

}  // namespace

std::vector<Vec3> read_curve_samples(const DrivingCurveSource& source) {
  const bool is_scene = lower_extension(source.file) == ".toml";
  if (is_scene && !source.own_unit.empty())
    throw InputError("found a 'unit' for a scene, expected none: scenes state their unit");
  const Scene scene = is_scene
                          ? read_scene(source.file)
                          : scene_of_lines({source.file}, {},
                                           source.own_unit.empty() ? source.unit : source.own_unit);
  const std::vector<CharacterLine> lines = faired_lines(scene, {}).lines;
  std::vector<std::string> names;
  for (const CharacterLine& line : lines) names.push_back(line.name);
  const auto found = source.curve.empty() && lines.size() == 1
                         ? lines.begin()
                         : std::find_if(lines.begin(), lines.end(), [&](const CharacterLine& line) {
                             return line.name == source.curve;
                           });
  if (found == lines.end())
    throw InputError(source.curve.empty()
                         ? "found " + std::to_string(lines.size()) + " curves in " +
                               source.file.filename().string() +
                               ", expected curve = \"…\", one of: " + comma_separated(names)
                         : "found '" + source.curve + "', expected a curve of " +
                               source.file.filename().string() + ", " +
                               expected_one_of(source.curve, names));
  constexpr int count = 4000;
  const double scale = unit_in_metres(scene.unit) / unit_in_metres(source.unit);
  std::vector<Vec3> samples;
  const InputCurve& curve = *found->curve;
  for (int i = 0; i <= count; ++i)
    samples.push_back(scale *
                      curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / count));
  return samples;
}

std::vector<Vec3> points_along(const std::vector<Vec3>& chain, bool closed,
                               const std::vector<Vec3>& samples) {
  const std::vector<double> along = length_shares(samples);
  std::vector<Vec3> ring = chain;
  if (closed) ring.push_back(chain.front());
  std::vector<double> shares = length_shares(ring);
  shares.resize(chain.size());
  std::vector<double> starts{0};
  if (closed) {
    constexpr double gap = 1e-3;  // of the extent
    double extent = 0;
    for (const Vec3& p : samples) extent = std::max(extent, (p - samples.front()).norm());
    if ((samples.back() - samples.front()).norm() > gap * extent)
      throw InputError("found an open curve for a closed chain, expected a closed one");
    constexpr int tried = 400;
    for (int k = 1; k < tried; ++k) starts.push_back(static_cast<double>(k) / tried);
  }
  std::vector<Vec3> best;
  double least = std::numeric_limits<double>::infinity();
  for (const double start : starts)
    for (const bool forward : {true, false}) {
      const double from = !closed && !forward ? 1 : start;
      std::vector<Vec3> points = candidate(samples, along, shares, from, forward);
      const double off = squared_distance(points, chain);
      if (off < least) {
        least = off;
        best = std::move(points);
      }
    }
  return best;
}

}  // namespace batten
