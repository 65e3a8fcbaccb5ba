// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/elements/hermite_segment.h"

namespace batten {
namespace {

/// A knot in time. `key`: index of the keyframe, or -1 if the value is 0 (end of the influence).
struct Knot {
  double time;
  int key;
};

std::vector<Knot> knots_of(std::span<const double> times, std::optional<double> from,
                           std::optional<double> to) {
  if (times.empty()) throw InputError("found no keyframes, expected one or more");
  for (size_t m = 0; m < times.size(); ++m)
    if (!std::isfinite(times[m]) || (m > 0 && !(times[m] > times[m - 1])))
      throw InputError("keyframe " + std::to_string(m + 1) + " of " + std::to_string(times.size()) +
                       ": time " + format_number(times[m]) + " is not after the keyframe before");
  if (from && !(*from < times.front()))
    throw InputError("found the influence start at time " + format_number(*from) +
                     ", expected it before the first keyframe, " + format_number(times.front()));
  if (to && !(*to > times.back()))
    throw InputError("found the influence end at time " + format_number(*to) +
                     ", expected it after the last keyframe, " + format_number(times.back()));
  std::vector<Knot> knots;
  if (from) knots.push_back({*from, -1});
  for (size_t m = 0; m < times.size(); ++m) knots.push_back({times[m], static_cast<int>(m)});
  if (to) knots.push_back({*to, -1});
  return knots;
}

/// Linear combination of the values at knots base … base + 3.
struct Combination {
  int base;
  std::array<double, 4> factor{};
  void add(int knot, double value) { factor[knot - base] += value; }
};

/// Adds `factor` times the slope at knot i.
void add_slope(const std::vector<Knot>& knots, int i, KeyframeExtrapolation ends, double factor,
               Combination& sum) {
  const int last = isize(knots) - 1;
  if (knots[i].key < 0) return;
  const auto secant = [&](int from, double weight) {
    const double by = weight / (knots[from + 1].time - knots[from].time);
    sum.add(from, -by);
    sum.add(from + 1, by);
  };
  if (i == 0 || i == last) {
    if (ends == KeyframeExtrapolation::Linear && last > 0) secant(i == 0 ? 0 : last - 1, factor);
    return;
  }
  // Slope of the parabola through three knots: the nearer neighbour has the larger weight.
  const double left = knots[i].time - knots[i - 1].time, right = knots[i + 1].time - knots[i].time;
  secant(i - 1, factor * right / (left + right));
  secant(i, factor * left / (left + right));
}

Combination combination_at(const std::vector<Knot>& knots, KeyframeExtrapolation ends, double t) {
  const auto after =
      std::upper_bound(knots.begin(), knots.end(), t,
                       [](double time, const Knot& knot) { return time < knot.time; });
  const int last = isize(knots) - 1, i = static_cast<int>(after - knots.begin()) - 1;
  Combination sum{std::clamp(i - 1, 0, last)};
  if (i < 0 || i == last || t == knots[i].time) {
    const int at = std::max(i, 0);
    sum.add(at, 1);
    if (t != knots[at].time) add_slope(knots, at, ends, t - knots[at].time, sum);
    return sum;
  }
  const double length = knots[i + 1].time - knots[i].time, s = (t - knots[i].time) / length;
  const HermiteSegment::Vector weight = HermiteSegment(length).evaluate(s);
  sum.add(i, weight[0]);
  sum.add(i + 1, weight[2]);
  add_slope(knots, i, ends, weight[1], sum);
  add_slope(knots, i + 1, ends, weight[3], sum);
  return sum;
}

/// Converts a combination to a row, without zero weights and knots with value 0.
KeyframeWeights::Row row_of(const std::vector<Knot>& knots, const Combination& sum) {
  KeyframeWeights::Row row;
  for (int j = 0; j < 4 && sum.base + j < isize(knots); ++j) {
    const int key = knots[sum.base + j].key;
    if (key < 0 || (sum.factor[j] == 0 && row.count == 0)) continue;
    if (row.count == 0) row.first = key;
    row.weights[row.count++] = sum.factor[j];
  }
  while (row.count > 0 && row.weights[row.count - 1] == 0) --row.count;
  return row;
}

/// Pairs (vertex, neighbour from which it is reached) in breadth-first order. Each patch starts at
/// its vertex with the smallest logarithm, which is not in the list.
std::vector<std::pair<int, int>> breadth_first(const MeshTopology& topology, const Points& logs) {
  std::vector<int> least(topology.component_count(), -1);
  for (int v = 0; v < topology.vertex_count(); ++v) {
    if (topology.component()[v] < 0) continue;
    int& best = least[topology.component()[v]];
    if (best < 0 || logs.row(v).norm() < logs.row(best).norm()) best = v;
  }
  std::vector<std::pair<int, int>> order;
  std::vector<char> reached(topology.vertex_count(), 0);
  const auto reach_from = [&](int v) {
    for (const int next : topology.neighbours(v))
      if (!reached[next]) {
        reached[next] = 1;
        order.emplace_back(next, v);
      }
  };
  for (const int seed : least) {
    size_t at = order.size();
    reached[seed] = 1;
    for (reach_from(seed); at < order.size(); ++at) reach_from(order[at].first);
  }
  return order;
}

}  // namespace

KeyframeWeights::KeyframeWeights(std::span<const double> times,
                                 std::span<const double> keyframe_times, KeyframeExtrapolation ends,
                                 std::optional<double> from, std::optional<double> to)
    : keyframes_(isize(keyframe_times)) {
  const std::vector<Knot> knots = knots_of(keyframe_times, from, to);
  for (const double t : times) rows_.push_back(row_of(knots, combination_at(knots, ends, t)));
}

KeyframeWeights KeyframeWeights::of_frames(std::span<const double> times,
                                           std::span<const int> keyframes,
                                           KeyframeExtrapolation ends,
                                           const InfluenceInterval& influence) {
  const auto time = [&](int frame, const char* what) {
    if (frame < 0 || frame >= isize(times))
      throw InputError(std::string(what) + " " + std::to_string(frame + 1) +
                       " is not one of the frames 1-" + std::to_string(times.size()));
    return times[frame];
  };
  std::vector<double> at;
  for (const int k : keyframes) at.push_back(time(k, "keyframe"));
  for (size_t m = 1; m < keyframes.size(); ++m)
    if (keyframes[m] <= keyframes[m - 1])
      throw InputError("found keyframe " + std::to_string(keyframes[m] + 1) + " after keyframe " +
                       std::to_string(keyframes[m - 1] + 1) + ", expected increasing frames");
  if (!keyframes.empty() && influence.from && *influence.from >= keyframes.front())
    throw InputError("found the influence start at frame " + std::to_string(*influence.from + 1) +
                     ", expected it before the first keyframe, " +
                     std::to_string(keyframes.front() + 1));
  if (!keyframes.empty() && influence.to && *influence.to <= keyframes.back())
    throw InputError("found the influence end at frame " + std::to_string(*influence.to + 1) +
                     ", expected it after the last keyframe, " +
                     std::to_string(keyframes.back() + 1));
  const auto end = [&](std::optional<int> frame) {
    return frame ? std::optional<double>(time(*frame, "end of the influence")) : std::nullopt;
  };
  return {times, at, ends, end(influence.from), end(influence.to)};
}

std::vector<double> frame_numbers(int frames) {
  std::vector<double> times(frames);
  for (int k = 0; k < frames; ++k) times[k] = k;
  return times;
}

Vec3 nearest_log(const Mat3& rotation, const Vec3& previous) {
  constexpr double full_turn = 2 * std::numbers::pi;
  const Vec3 shortest = to_rotation_vector(rotation);
  const double angle = shortest.norm(), before = previous.norm();
  const auto whole = [](double rotations) { return std::floor(rotations + 0.5); };
  if (angle < 1e-12) {
    const double k = whole(before / full_turn);
    return k > 0 ? Vec3(k * full_turn / before * previous) : shortest;
  }
  const Vec3 axis = shortest / angle;
  const double k = whole((previous.dot(axis) - angle) / full_turn);
  return k == 0 ? shortest : Vec3((angle + k * full_turn) * axis);
}

Points unwrapped_logs(std::span<const Mat3> rotations) {
  Points logs(isize(rotations), 3);
  Vec3 previous = Vec3::Zero();
  for (int k = 0; k < isize(rotations); ++k)
    logs.row(k) = previous = nearest_log(rotations[k], previous);
  return logs;
}

std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes) {
  std::vector<Points> logs;
  for (const std::vector<Mat3>& rotations : rotations_at_keyframes) {
    if (rotations.size() != rotations_at_keyframes.front().size())
      throw InputError("keyframe " + std::to_string(logs.size() + 1) + " has " +
                       std::to_string(rotations.size()) + " rotations, expected " +
                       std::to_string(rotations_at_keyframes.front().size()) +
                       " as in the first keyframe");
    Points of_keyframe(isize(rotations), 3);
    for (int v = 0; v < isize(rotations); ++v)
      of_keyframe.row(v) = nearest_log(
          rotations[v], logs.empty() ? Vec3(Vec3::Zero()) : Vec3(logs.back().row(v).transpose()));
    logs.push_back(std::move(of_keyframe));
  }
  return logs;
}

std::vector<Points> unwrapped_logs(const std::vector<std::vector<Mat3>>& rotations_at_keyframes,
                                   const MeshTopology& topology) {
  // First follow every vertex independently: that is correct for the start vertices.
  std::vector<Points> logs = unwrapped_logs(rotations_at_keyframes);
  if (logs.empty()) return logs;
  if (logs.front().rows() != topology.vertex_count())
    throw InputError("found " + std::to_string(logs.front().rows()) + " rotations for " +
                     std::to_string(topology.vertex_count()) + " vertices, expected one for each");
  for (const auto& [vertex, from] : breadth_first(topology, logs.front()))
    for (size_t m = 0; m < logs.size(); ++m)
      logs[m].row(vertex) =
          nearest_log(rotations_at_keyframes[m][vertex], logs[m].row(from).transpose());
  return logs;
}

void interpolate_logs(const KeyframeWeights::Row& row, const std::vector<Points>& logs,
                      Points& result) {
  if (logs.empty()) throw InputError("found no rotations at keyframes, expected one or more");
  result.resize(logs.front().rows(), 3);
  result.setZero();
  for (int j = 0; j < row.count; ++j) result += row.weights[j] * logs[row.first + j];
}

std::vector<Mat3> interpolated_rotations(const KeyframeWeights& weights,
                                         std::span<const Mat3> rotations) {
  if (isize(rotations) != weights.keyframe_count())
    throw InputError("found " + std::to_string(rotations.size()) + " rotations for " +
                     std::to_string(weights.keyframe_count()) +
                     " keyframes, expected one for each");
  const Points logs = unwrapped_logs(rotations);
  std::vector<Mat3> result;
  for (int k = 0; k < weights.frame_count(); ++k) {
    const KeyframeWeights::Row& row = weights.row(k);
    Vec3 log = Vec3::Zero();
    for (int j = 0; j < row.count; ++j) log += row.weights[j] * logs.row(row.first + j).transpose();
    const bool given = row.count == 1 && row.weights[0] == 1;
    result.push_back(given ? rotations[row.first] : rotation_matrix(log));
  }
  return result;
}

}  // namespace batten
