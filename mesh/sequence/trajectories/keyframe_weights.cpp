#include "batten/mesh/sequence/trajectories/keyframe_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/solvers/band_cholesky.h"

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
  sum.add(i, (1 + 2 * s) * (1 - s) * (1 - s));
  sum.add(i + 1, s * s * (3 - 2 * s));
  add_slope(knots, i, ends, length * s * (1 - s) * (1 - s), sum);
  add_slope(knots, i + 1, ends, -length * s * s * (1 - s), sum);
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

PiecewiseCubic PiecewiseCubic::through(std::vector<double> knots, const Points& values, Ends ends) {
  const int n = isize(knots);
  if (n < 2) return {std::move(knots), values, Points::Zero(n, 3)};
  // Conditions: continuous second derivatives; zero curvature at natural ends.
  BandCholesky A;
  A.reset(n, 1);
  Points slopes = Points::Zero(n, 3);
  for (int i = 0; i + 1 < n; ++i) {
    const double h = knots[i + 1] - knots[i];
    const Eigen::RowVector3d secant = (values.row(i + 1) - values.row(i)) / h;
    A.add(i, i, 2 / h);
    A.add(i + 1, i + 1, 2 / h);
    A.add(i + 1, i, 1 / h);
    slopes.row(i) += 3 / h * secant;
    slopes.row(i + 1) += 3 / h * secant;
  }
  if (ends == Ends::Flat) {
    A.fix(0, Vec3::Zero(), slopes);
    A.fix(n - 1, Vec3::Zero(), slopes);
  }
  if (!A.factorize()) throw std::logic_error("the knots of a curve must increase");
  A.solve(slopes);
  return {std::move(knots), values, slopes};
}

PiecewiseCubic PiecewiseCubic::fitted(const std::vector<double>& u, const Points& values,
                                      int spans) {
  const double first = u.front(), h = (u.back() - first) / spans;
  // Fit the difference to the line between the ends, so that straight lines are reproduced to
  // rounding.
  const Eigen::RowVector3d start = values.row(0),
                           rise = (values.row(values.rows() - 1) - start) / (u.back() - first);
  BandCholesky A;
  A.reset(spans + 3, 3);
  Points poles = Points::Zero(spans + 3, 3);
  for (int k = 0; k < isize(u); ++k) {
    const int piece = std::clamp(static_cast<int>((u[k] - first) / h), 0, spans - 1);
    const double s = (u[k] - first) / h - piece, r = 1 - s;
    const std::array<double, 4> basis = {r * r * r / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
                                         (3 * r * r * r - 6 * r * r + 4) / 6, s * s * s / 6};
    const Eigen::RowVector3d off = values.row(k) - start - (u[k] - first) * rise;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j <= i; ++j) A.add(piece + i, piece + j, basis[i] * basis[j]);
      poles.row(piece + i) += basis[i] * off;
    }
  }
  if (!A.factorize()) throw std::logic_error("too few values to fit a curve");
  A.solve(poles);
  std::vector<double> knots(spans + 1);
  Points at(spans + 1, 3), slopes(spans + 1, 3);
  for (int i = 0; i <= spans; ++i) {
    knots[i] = i < spans ? first + i * h : u.back();
    at.row(i) = start + (knots[i] - first) * rise +
                (poles.row(i) + 4 * poles.row(i + 1) + poles.row(i + 2)) / 6;
    slopes.row(i) = rise + (poles.row(i + 2) - poles.row(i)) / (2 * h);
  }
  return {std::move(knots), at, slopes};
}

int PiecewiseCubic::piece(double u) const {
  const auto after = std::upper_bound(knots_.begin(), knots_.end(), u);
  return std::clamp(static_cast<int>(after - knots_.begin()) - 1, 0,
                    std::max(isize(knots_) - 2, 0));
}

Vec3 PiecewiseCubic::at(double u) const {
  const int last = isize(knots_) - 1;
  for (const int end : {0, last})
    if (end == 0 ? u <= knots_[0] : u >= knots_[last])
      return values_.row(end) + (u - knots_[end]) * slopes_.row(end);
  const int i = piece(u);
  const double h = knots_[i + 1] - knots_[i], s = (u - knots_[i]) / h, r = 1 - s;
  return values_.row(i) + s * s * (3 - 2 * s) * (values_.row(i + 1) - values_.row(i)) +
         h * s * r * (r * slopes_.row(i) - s * slopes_.row(i + 1));
}

Vec3 PiecewiseCubic::slope(double u) const {
  const int last = isize(knots_) - 1;
  if (u <= knots_[0]) return slopes_.row(0);
  if (u >= knots_[last]) return slopes_.row(last);
  const int i = piece(u);
  const double h = knots_[i + 1] - knots_[i], s = (u - knots_[i]) / h, r = 1 - s;
  return 6 * s * r / h * (values_.row(i + 1) - values_.row(i)) + r * (r - 2 * s) * slopes_.row(i) +
         s * (s - 2 * r) * slopes_.row(i + 1);
}

}  // namespace batten
