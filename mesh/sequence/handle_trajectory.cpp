#include "batten/mesh/sequence/handle_trajectory.h"

#include <algorithm>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/mesh/sequence/piecewise_cubic.h"

namespace batten {
namespace {

using Smoothness = TrajectoryOptions::Smoothness;

std::string counted(long count, const char* what) { return std::to_string(count) + " " + what; }

std::vector<double> times_of(const TrajectoryOptions& options, int frames) {
  if (options.times.empty()) return frame_numbers(frames);
  if (isize(options.times) != frames)
    throw InputError(counted(isize(options.times), "times for ") + counted(frames, "frames"));
  for (int k = 1; k < frames; ++k)
    if (!(options.times[k] > options.times[k - 1]))
      throw InputError("frame " + std::to_string(k + 1) +
                       " has a time that is not after the one before");
  return options.times;
}

/// x over all times from its values at knots, constant outside.
Points spread(const std::vector<double>& knots, const Points& values, Smoothness smoothness,
              const std::vector<double>& times) {
  const PiecewiseCubic smooth = PiecewiseCubic::through(knots, values, PiecewiseCubic::Ends::Flat);
  Points x(isize(times), 3);
  for (int k = 0; k < isize(times); ++k) {
    const double t = std::clamp(times[k], knots.front(), knots.back());
    const int after =
        static_cast<int>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin());
    const int i = std::max(after - 1, 0);
    if (t == knots[i] || after == isize(knots)) {
      x.row(k) = values.row(i);
    } else if (smoothness == Smoothness::Smooth) {
      x.row(k) = smooth.at(t);
    } else {
      const double s = (t - knots[i]) / (knots[after] - knots[i]);
      x.row(k) = values.row(i) + s * (values.row(after) - values.row(i));
    }
  }
  return x;
}

}  // namespace

Points edited_centres(const Points& centres, const std::vector<Mat3>& rotations,
                      const std::vector<int>& keyframes, const Points& centres_at_keyframes,
                      const TrajectoryOptions& options) {
  const int frames = static_cast<int>(centres.rows());
  if (isize(rotations) != frames)
    throw InputError(counted(isize(rotations), "rotations for ") + counted(frames, "frames"));
  if (centres_at_keyframes.rows() != isize(keyframes))
    throw InputError(counted(centres_at_keyframes.rows(), "centroids for ") +
                     counted(isize(keyframes), "keyframes"));
  const std::vector<double> times = times_of(options, frames);
  const auto [from, to] = options.influence;
  KeyframeWeights::of_frames(times, keyframes, KeyframeExtrapolation::None,
                             options.influence);  // checks

  // h = g - c, so that without rotations it is zero to the last bit.
  Points h = Points::Zero(frames, 3);
  for (int k = 0; k + 1 < frames; ++k) {
    const Mat3 change = 0.5 * (rotations[k] + rotations[k + 1]) - Mat3::Identity();
    h.row(k + 1) = h.row(k) + (centres.row(k + 1) - centres.row(k)) * change.transpose();
  }
  std::vector<double> knots;
  std::vector<Eigen::RowVector3d> rest;
  const auto add = [&](int frame, const Eigen::RowVector3d& change) {
    knots.push_back(times[frame]);
    rest.push_back(change - h.row(frame));
  };
  if (from) add(*from, Eigen::RowVector3d::Zero());
  for (int m = 0; m < isize(keyframes); ++m)
    add(keyframes[m], centres_at_keyframes.row(m) - centres.row(keyframes[m]));
  if (to) add(*to, Eigen::RowVector3d::Zero());
  Points values(isize(rest), 3);
  for (int i = 0; i < isize(rest); ++i) values.row(i) = rest[i];

  Points result = centres + (h + spread(knots, values, options.smoothness, times));
  for (int m = 0; m < isize(keyframes); ++m) result.row(keyframes[m]) = centres_at_keyframes.row(m);
  if (from) result.topRows(*from + 1) = centres.topRows(*from + 1);
  if (to) result.bottomRows(frames - *to) = centres.bottomRows(frames - *to);
  return result;
}

Trajectory edited(const Trajectory& trajectory, const std::vector<HandleKeyframe>& keyframes,
                  const TrajectoryOptions& options) {
  const std::vector<double> times = times_of(options, trajectory.frame_count());
  std::vector<int> at;
  std::vector<Mat3> changes;
  for (const HandleKeyframe& keyframe : keyframes) {
    at.push_back(keyframe.frame);
    changes.push_back(keyframe.motion.rotation);
  }
  const auto weights = KeyframeWeights::of_frames(times, at, options.ends, options.influence);
  const std::vector<Mat3> rotations = interpolated_rotations(weights, changes);
  Points centres(isize(keyframes), 3);
  for (int m = 0; m < isize(keyframes); ++m)
    centres.row(m) = keyframes[m].motion(trajectory.centres.row(at[m]).transpose());
  Trajectory result{edited_centres(trajectory.centres, rotations, at, centres, options), {}};
  for (int k = 0; k < trajectory.frame_count(); ++k)
    result.rotations.push_back(rotations[k] * trajectory.rotations[k]);
  return result;
}

}  // namespace batten
