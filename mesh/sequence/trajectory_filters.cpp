#include "batten/mesh/sequence/trajectory_filters.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/rotations.h"

namespace batten {
namespace {

Trajectory filtered_signal(const Trajectory& t, const SignalFilter& filter,
                           const FilterOptions& options) {
  return {filter(t.centres, options.padding),
          options.rotations ? filter(t.rotations, options.padding) : t.rotations};
}

/// Of each frame how far it is filtered: 0 in footprints, 1 away from them.
std::vector<double> filter_weights(const std::vector<FootContact>& foot_contacts, int frames,
                                   int blend) {
  std::vector<double> weight(frames, 1.0);
  for (int k = 0; k < frames; ++k)
    for (const FootContact& f : foot_contacts) {
      const int away = std::max({f.first - k, k - f.last, 0});
      const double t = std::min(1.0, away / (blend + 1.0));
      weight[k] = std::min(weight[k], t * t * (3 - 2 * t));
    }
  return weight;
}

/// `to` where the share is 1, `from` where it is 0.
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

/// Parents before their children.
std::vector<int> order_of(const std::vector<FilteredHandle>& handles) {
  const int n = isize(handles);
  std::vector<int> order;
  std::vector<char> done(n, 0);
  for (int h = 0; h < n; ++h)
    if (handles[h].parent < -1 || handles[h].parent >= n)
      throw InputError(handles[h].name + ": its parent is none of the " + std::to_string(n) +
                       " handles");
  for (bool more = true; more;) {
    more = false;
    for (int h = 0; h < n; ++h) {
      if (done[h] || (handles[h].parent >= 0 && !done[handles[h].parent])) continue;
      order.push_back(h);
      done[h] = more = true;
    }
  }
  for (int h = 0; h < n; ++h)
    if (!done[h])
      throw InputError(handles[h].name + ": hangs on itself, or on handles in a circle");
  return order;
}

}  // namespace

Trajectory relative(const Trajectory& child, const Trajectory& parent) {
  if (child.frame_count() != parent.frame_count())
    throw InputError(std::to_string(child.frame_count()) + " frames relative to " +
                     std::to_string(parent.frame_count()));
  Trajectory result = child;
  for (int k = 0; k < child.frame_count(); ++k) {
    result.centres.row(k) = (child.centres.row(k) - parent.centres.row(k)) * parent.rotations[k];
    result.rotations[k] = parent.rotations[k].transpose() * child.rotations[k];
  }
  return result;
}

Trajectory composed(const Trajectory& relative, const Trajectory& parent) {
  if (relative.frame_count() != parent.frame_count())
    throw InputError(std::to_string(relative.frame_count()) + " frames relative to " +
                     std::to_string(parent.frame_count()));
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
  if (options.blend < 0) throw InputError("filter: fewer than 0 frames of blend");
  FilteredTrajectories result{filtered_signal(root, filter, options), {}};
  result.handles.resize(handles.size());
  for (const int h : order_of(handles)) {
    const FilteredHandle& handle = handles[h];
    if (handle.trajectory.frame_count() != frames)
      throw InputError(handle.name + ": " + std::to_string(handle.trajectory.frame_count()) +
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

}  // namespace batten
