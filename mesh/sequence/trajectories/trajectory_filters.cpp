// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/trajectory_filters.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/cubic.h"
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"

namespace batten {
namespace {

Trajectory filtered_signal(const Trajectory& t, const SignalFilter& filter,
                           const FilterOptions& options) {
  return {filter(t.centres, options.padding),
          options.rotations ? filter(t.rotations, options.padding) : t.rotations};
}

/// Weight of the filtered pose per frame: 0 during contacts, 1 away from them.
std::vector<double> filter_weights(const std::vector<FootContact>& foot_contacts, int frames,
                                   int blend) {
  std::vector<double> weight(frames, 1.0);
  for (int k = 0; k < frames; ++k)
    for (const FootContact& f : foot_contacts) {
      const int away = std::max({f.first - k, k - f.last, 0});
      const double t = std::min(1.0, away / (blend + 1.0));
      weight[k] = std::min(weight[k], smooth_step(t));
    }
  return weight;
}

/// Blends `to` with `from`: weight 1 gives `to`, weight 0 gives `from`.
void blend(const Trajectory& from, const std::vector<double>& weight, Trajectory& to) {
  for (int k = 0; k < from.frame_count(); ++k) {
    if (weight[k] == 1) continue;
    const Eigen::RowVector3d step = to.centres.row(k) - from.centres.row(k);
    to.centres.row(k) = from.centres.row(k) + weight[k] * step;
    const Vec3 rotation_vector =
        weight[k] * to_rotation_vector(Mat3(from.rotations[k].transpose() * to.rotations[k]));
    to.rotations[k] = weight[k] == 0 ? from.rotations[k]
                                     : Mat3(from.rotations[k] * rotation_matrix(rotation_vector));
  }
}

/// Indices with parents before their children.
std::vector<int> order_of(const std::vector<FilteredHandle>& handles) {
  const int n = isize(handles);
  std::vector<int> order;
  std::vector<char> done(n, 0);
  for (int h = 0; h < n; ++h)
    if (handles[h].parent < -1 || handles[h].parent >= n)
      throw InputError(handles[h].name + ": found parent " + std::to_string(handles[h].parent) +
                       ", expected one of the " + std::to_string(n) + " handles");
  for (bool more = true; more;) {
    more = false;
    for (int h = 0; h < n; ++h) {
      if (done[h] || (handles[h].parent >= 0 && !done[handles[h].parent])) continue;
      order.push_back(h);
      done[h] = more = true;
    }
  }
  for (int h = 0; h < n; ++h)
    if (!done[h]) throw InputError(handles[h].name + ": its parents form a cycle");
  return order;
}

}  // namespace

Trajectory relative(const Trajectory& child, const Trajectory& parent) {
  if (child.frame_count() != parent.frame_count())
    throw InputError("found a trajectory of " + std::to_string(child.frame_count()) +
                     " frames, expected " + std::to_string(parent.frame_count()) +
                     " as its parent has");
  Trajectory result = child;
  for (int k = 0; k < child.frame_count(); ++k) {
    result.centres.row(k) = (child.centres.row(k) - parent.centres.row(k)) * parent.rotations[k];
    result.rotations[k] = parent.rotations[k].transpose() * child.rotations[k];
  }
  return result;
}

Trajectory composed(const Trajectory& relative, const Trajectory& parent) {
  if (relative.frame_count() != parent.frame_count())
    throw InputError("found a trajectory of " + std::to_string(relative.frame_count()) +
                     " frames, expected " + std::to_string(parent.frame_count()) +
                     " as its parent has");
  Trajectory result = relative;
  for (int k = 0; k < relative.frame_count(); ++k) {
    result.centres.row(k) =
        parent.centres.row(k) + relative.centres.row(k) * parent.rotations[k].transpose();
    result.rotations[k] = parent.rotations[k] * relative.rotations[k];
  }
  return result;
}

FilteredTrajectories filtered(const Trajectory& root, const std::vector<FilteredHandle>& handles,
                              const SignalFilter& filter, const FilterOptions& options) {
  const int frames = root.frame_count();
  if (options.blend < 0)
    throw InputError("filter: found blend = " + std::to_string(options.blend) +
                     ", expected 0 or more frames");
  FilteredTrajectories result{filtered_signal(root, filter, options), {}};
  result.handles.resize(handles.size());
  for (const int h : order_of(handles)) {
    const FilteredHandle& handle = handles[h];
    if (handle.trajectory.frame_count() != frames)
      throw InputError(handle.name + ": found " + std::to_string(handle.trajectory.frame_count()) +
                       " frames, expected " + std::to_string(frames) + " as the root has");
    check(handle.foot_contacts, frames, handle.name);
    const bool at_root = handle.parent < 0;
    const Trajectory& before = at_root ? root : handles[handle.parent].trajectory;
    const Trajectory& after = at_root ? result.root : result.handles[handle.parent];
    Trajectory& to = result.handles[h];
    to = composed(filtered_signal(relative(handle.trajectory, before), filter, options), after);
    blend(handle.trajectory, filter_weights(handle.foot_contacts, frames, options.blend), to);
  }
  return result;
}

namespace {

/// Sampled Gaussian for offsets 1, 2, …, normalised such that the sum over both sides and the
/// centre is 1.
std::vector<double> gaussian(double sigma) {
  if (!(sigma > 0 && sigma <= 1e5))
    throw InputError("filter: found sigma = " + format_number(sigma) +
                     ", expected a number above 0, up to 1e5 frames");
  std::vector<double> g(static_cast<size_t>(std::ceil(7 * sigma)));
  double sum = 0;
  for (size_t j = g.size(); j-- > 0;) {
    const double s = static_cast<double>(j + 1) / sigma;
    sum += g[j] = std::exp(-s * s / 2);
  }
  for (double& value : g) value /= 1 + 2 * sum;
  return g;
}

/// Extends a signal by `more` values at each end. `beyond`: computes a value from the end value and
/// the value equally far inside.
template <class Value, class Beyond>
std::vector<Value> extended(const std::vector<Value>& x, int more, const Beyond& beyond) {
  const int last = isize(x) - 1;
  std::vector<Value> all(x.size() + 2 * static_cast<size_t>(more), x.front());
  std::copy(x.begin(), x.end(), all.begin() + more);
  if (last == 0) return all;
  // Outwards on both sides at the same time: if the signal is short, the values needed farther
  // inside are then already there.
  Value* const at = all.data() + more;
  for (int j = 1; j <= more; ++j) {
    at[-j] = beyond(at[0], at[j]);
    at[last + j] = beyond(at[last], at[last - j]);
  }
  return all;
}

}  // namespace

SignalFilter::SignalFilter(double sum, std::vector<double> taps)
    : sum_(sum), taps_(std::move(taps)) {}

SignalFilter SignalFilter::low_pass(double sigma) { return {1, gaussian(sigma)}; }

SignalFilter SignalFilter::high_pass(double sigma) {
  std::vector<double> taps = gaussian(sigma);
  for (double& h : taps) h = -h;
  return {0, taps};
}

SignalFilter SignalFilter::cartoon(double sigma, double amount) {
  std::vector<double> taps = gaussian(sigma);
  for (size_t j = 0; j < taps.size(); ++j) {
    const double s = static_cast<double>(j + 1) / sigma;
    taps[j] *= -amount * (s * s - 1);
  }
  return {1, taps};
}

double SignalFilter::response(double omega) const {
  double result = 0;
  for (size_t j = taps_.size(); j-- > 0;) {
    const double s = std::sin(omega * static_cast<double>(j + 1) / 2);
    result -= 4 * taps_[j] * s * s;
  }
  return sum_ + result;
}

Points SignalFilter::operator()(const Points& signal, Padding padding) const {
  if (signal.rows() == 0) return signal;
  const int more = isize(taps_);
  std::vector<Vec3> rows(signal.rows());
  for (int k = 0; k < isize(rows); ++k) rows[k] = signal.row(k);
  const std::vector<Vec3> x = extended(rows, more, [&](const Vec3& end, const Vec3& inside) {
    return padding == Padding::Even ? inside : Vec3(2 * end - inside);
  });
  Points result(signal.rows(), 3);
  for (int k = 0; k < isize(rows); ++k) {
    const Vec3* const at = x.data() + more + k;
    Vec3 change = Vec3::Zero();
    for (int j = more; j > 0; --j) change += taps_[j - 1] * ((at[j] - at[0]) + (at[-j] - at[0]));
    result.row(k) = sum_ * at[0] + change;
  }
  return result;
}

std::vector<Mat3> SignalFilter::operator()(const std::vector<Mat3>& rotations,
                                           Padding padding) const {
  if (rotations.empty()) return rotations;
  const int more = isize(taps_);
  const std::vector<Mat3> R = extended(rotations, more, [&](const Mat3& end, const Mat3& inside) {
    return padding == Padding::Even ? inside : Mat3(end * inside.transpose() * end);
  });
  std::vector<Mat3> result;
  const Points logs = unwrapped_logs(rotations);
  for (int k = 0; k < isize(rotations); ++k) {
    const Mat3* const at = R.data() + more + k;
    Vec3 change = Vec3::Zero();
    for (const int side : {-1, 1}) {
      Vec3 log = Vec3::Zero();
      for (int j = 1; j <= more; ++j) {
        log = nearest_log(Mat3(at[0].transpose() * at[side * j]), log);
        change += taps_[j - 1] * log;
      }
    }
    const Mat3 own = sum_ == 1 ? at[0] : rotation_matrix(sum_ * logs.row(k).transpose());
    result.push_back(own * rotation_matrix(change));
  }
  return result;
}

}  // namespace batten
