#include "batten/mesh/sequence/handle_trajectory.h"

#include <algorithm>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/mesh/sequence/piecewise_cubic.h"

namespace batten {
namespace {

using Smoothness = TrajectoryOptions::Smoothness;

std::string counted(long count, const char* what) { return std::to_string(count) + " " + what; }

std::vector<double> times_of(const TrajectoryOptions& options, int frames) {
  if (options.times.empty()) return frame_numbers(frames);
  if (count_of(options.times) != frames)
    throw InputError(counted(count_of(options.times), "times for ") + counted(frames, "frames"));
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
  Points x(count_of(times), 3);
  for (int k = 0; k < count_of(times); ++k) {
    const double t = std::clamp(times[k], knots.front(), knots.back());
    const int after =
        static_cast<int>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin());
    const int i = std::max(after - 1, 0);
    if (t == knots[i] || after == count_of(knots)) {
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

Points edited_centres(const Points& centres, const std::vector<Mat3>& turns,
                      const std::vector<int>& keyframes, const Points& centres_at_keyframes,
                      const TrajectoryOptions& options) {
  const int frames = static_cast<int>(centres.rows());
  if (count_of(turns) != frames)
    throw InputError(counted(count_of(turns), "rotations for ") + counted(frames, "frames"));
  if (centres_at_keyframes.rows() != count_of(keyframes))
    throw InputError(counted(centres_at_keyframes.rows(), "centroids for ") +
                     counted(count_of(keyframes), "keyframes"));
  const std::vector<double> times = times_of(options, frames);
  const auto [from, to] = options.influence;
  KeyframeWeights::of_frames(times, keyframes, KeyframeEnds::None, options.influence);  // checks

  // h = g - c, so that without rotations it is zero to the last bit.
  Points h = Points::Zero(frames, 3);
  for (int k = 0; k + 1 < frames; ++k) {
    const Mat3 change = 0.5 * (turns[k] + turns[k + 1]) - Mat3::Identity();
    h.row(k + 1) = h.row(k) + (centres.row(k + 1) - centres.row(k)) * change.transpose();
  }
  std::vector<double> knots;
  std::vector<Eigen::RowVector3d> rest;
  const auto add = [&](int frame, const Eigen::RowVector3d& change) {
    knots.push_back(times[frame]);
    rest.push_back(change - h.row(frame));
  };
  if (from) add(*from, Eigen::RowVector3d::Zero());
  for (int m = 0; m < count_of(keyframes); ++m)
    add(keyframes[m], centres_at_keyframes.row(m) - centres.row(keyframes[m]));
  if (to) add(*to, Eigen::RowVector3d::Zero());
  Points values(count_of(rest), 3);
  for (int i = 0; i < count_of(rest); ++i) values.row(i) = rest[i];

  Points result = centres + (h + spread(knots, values, options.smoothness, times));
  for (int m = 0; m < count_of(keyframes); ++m)
    result.row(keyframes[m]) = centres_at_keyframes.row(m);
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
    changes.push_back(keyframe.motion.turn);
  }
  const auto weights = KeyframeWeights::of_frames(times, at, options.ends, options.influence);
  const std::vector<Mat3> turns = interpolated_turns(weights, changes);
  Points centres(count_of(keyframes), 3);
  for (int m = 0; m < count_of(keyframes); ++m)
    centres.row(m) = keyframes[m].motion(trajectory.centres.row(at[m]).transpose());
  Trajectory result{edited_centres(trajectory.centres, turns, at, centres, options), {}};
  for (int k = 0; k < trajectory.frame_count(); ++k)
    result.turns.push_back(turns[k] * trajectory.turns[k]);
  return result;
}

}  // namespace batten
