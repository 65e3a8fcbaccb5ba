// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/trajectories/handle_trajectory.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/cubic.h"
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"

namespace batten {
namespace {

using Smoothness = TrajectoryOptions::Smoothness;

std::string counted(long count, const char* what) { return std::to_string(count) + " " + what; }

std::vector<double> times_of(const TrajectoryOptions& options, int frames) {
  if (options.times.empty()) return frame_numbers(frames);
  if (isize(options.times) != frames)
    throw InputError("found " + counted(isize(options.times), "times for ") +
                     counted(frames, "frames, expected one for each"));
  for (int k = 1; k < frames; ++k)
    if (!(options.times[k] > options.times[k - 1]))
      throw InputError("frame " + std::to_string(k + 1) +
                       " has a time that is not after that of the frame before");
  return options.times;
}

/// x at all times from its values at the knots, constant outside.
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
    throw InputError("found " + counted(isize(rotations), "rotations for ") +
                     counted(frames, "frames, expected one for each"));
  if (centres_at_keyframes.rows() != isize(keyframes))
    throw InputError("found " + counted(centres_at_keyframes.rows(), "centroids for ") +
                     counted(isize(keyframes), "keyframes, expected one for each"));
  const std::vector<double> times = times_of(options, frames);
  const auto [from, to] = options.influence;
  KeyframeWeights::of_frames(times, keyframes, KeyframeExtrapolation::None,
                             options.influence);  // only for its checks

  // h = g - c: without rotations it is exactly zero.
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

namespace {

/// fit_similarity() restricted to rotations about one axis.
Similarity fit_about(const Points& before, const Points& after, const Vec3& axis, bool scales) {
  const Eigen::RowVector3d from = before.colwise().mean(), to = after.colwise().mean();
  const Points x = before.rowwise() - from, y = after.rowwise() - to;
  const Mat3 covariance = y.transpose() * x;
  // Σ y·R(φ)x = along + cosine cos φ + sine sin φ.
  const double along = axis.dot(covariance * axis), cosine = covariance.trace() - along;
  const double sine =
      axis.dot(Vec3(covariance(2, 1) - covariance(1, 2), covariance(0, 2) - covariance(2, 0),
                    covariance(1, 0) - covariance(0, 1)));
  Similarity best;
  const double amplitude = std::hypot(cosine, sine);
  if (amplitude > 1e-14 * x.norm() * y.norm())
    best.R = Eigen::AngleAxisd(std::atan2(sine, cosine), axis).matrix();
  if (scales && x.squaredNorm() > 0)
    best.scale = std::max(along + amplitude, 0.0) / x.squaredNorm();
  best.translation = to.transpose() - best.scale * (best.R * from.transpose());
  const Points off = y - best.scale * x * best.R.transpose();
  const double size = (before.colwise().maxCoeff() - before.colwise().minCoeff()).norm();
  best.max_error = off.rowwise().norm().maxCoeff() / (size > 0 ? size : 1);
  return best;
}

/// R_base exp(Σ w_j log R_baseᵀR_j). Logarithms relative to a nearby rotation are free of full
/// turns.
Mat3 interpolate_rotation(const std::vector<Mat3>& rotations, const KeyframeWeights::Row& row,
                          int base) {
  Vec3 sum = Vec3::Zero();
  for (int j = 0; j < row.count; ++j)
    sum += row.weights[j] *
           to_rotation_vector(Mat3(rotations[base].transpose() * rotations[row.first + j]));
  return rotations[base] * rotation_matrix(sum);
}

bool is_stationary(const Points& p) {
  const double size = (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
  return size <= 1e-14 * p.cwiseAbs().maxCoeff();
}

}  // namespace

Trajectory resampled(const Trajectory& trajectory, int frames, Resampling how) {
  const int given = trajectory.frame_count();
  if (given < 1 || frames < 1)
    throw InputError("resampling from " + std::to_string(given) + " to " + std::to_string(frames) +
                     " frames, expected one or more of both");
  if (frames == given) return trajectory;
  std::vector<double> times = frame_numbers(frames);
  for (double& t : times) t = frames > 1 ? t * (given - 1) / (frames - 1) : 0;
  const KeyframeWeights weights(times, frame_numbers(given), KeyframeExtrapolation::Linear);
  Trajectory result;
  result.centres = Points::Zero(frames, 3);
  for (int k = 0; k < frames; ++k) {
    const int base = std::clamp(static_cast<int>(times[k]), 0, std::max(given - 2, 0));
    KeyframeWeights::Row row = weights.row(k);
    if (how == Resampling::Linear)
      row = {base, std::min(given, 2), {1 - (times[k] - base), times[k] - base}};
    for (int j = 0; j < row.count; ++j)
      result.centres.row(k) += row.weights[j] * trajectory.centres.row(row.first + j);
    result.rotations.push_back(interpolate_rotation(trajectory.rotations, row, base));
  }
  return result;
}

Similarity alignment(const Trajectory& from, const Trajectory& to,
                     const AlignmentOptions& options) {
  if (from.frame_count() < 1 || to.frame_count() < 1)
    throw InputError("alignment: a trajectory has no frames");
  if (options.about && !(options.about->norm() > 0 && options.about->allFinite()))
    throw InputError("alignment: the axis `about` has length 0 or is not finite");
  const Points a = resampled(from, to.frame_count(), options.resampling).centres;
  if (is_stationary(a) || is_stationary(to.centres)) {
    Similarity translation;
    translation.translation = (to.centres - a).colwise().mean();
    return translation;
  }
  if (options.about) return fit_about(a, to.centres, options.about->normalized(), options.scales);
  std::vector<int> all(to.frame_count());
  std::iota(all.begin(), all.end(), 0);
  return options.scales ? fit_similarity(a, to.centres, all)
                        : fit_similarity(a, to.centres, all, 1.0);
}

Trajectory aligned(const Trajectory& trajectory, const Similarity& similarity) {
  Trajectory result = trajectory;
  for (int k = 0; k < trajectory.frame_count(); ++k) {
    result.centres.row(k) =
        similarity.scale * (similarity.R * trajectory.centres.row(k).transpose()) +
        similarity.translation;
    result.rotations[k] = similarity.R * trajectory.rotations[k] * similarity.R.transpose();
  }
  return result;
}

namespace {

/// The similarity that maps the trajectories `from` to the trajectories `to`.
Similarity joint_alignment(const std::vector<Trajectory>& from, const std::vector<Trajectory>& to,
                           const std::optional<Vec3>& about) {
  const auto stacked = [](const std::vector<Trajectory>& all) {
    Trajectory one;
    one.centres.resize(all.front().frame_count() * isize(all), 3);
    for (size_t p = 0; p < all.size(); ++p) {
      one.centres.middleRows(static_cast<long>(p) * all[p].frame_count(), all[p].frame_count()) =
          all[p].centres;
      one.rotations.insert(one.rotations.end(), all[p].rotations.begin(), all[p].rotations.end());
    }
    return one;
  };
  AlignmentOptions options;
  options.about = about;
  return alignment(stacked(from), stacked(to), options);
}

void align_rotations(Trajectory& trajectory, const Trajectory& own) {
  Mat3 sum = Mat3::Zero();
  for (size_t k = 0; k < own.rotations.size(); ++k)
    sum += trajectory.rotations[k].transpose() * own.rotations[k];
  const Mat3 between = nearest_rotation(sum);
  for (Mat3& rotation : trajectory.rotations) rotation = rotation * between;
}

}  // namespace

std::vector<Trajectory> transferred(const std::vector<Trajectory>& from,
                                    const std::vector<Trajectory>& own,
                                    const MotionTransferOptions& options) {
  using Align = MotionTransferOptions::Align;
  if (from.size() != own.size())
    throw InputError("transfer of motion: found " + std::to_string(from.size()) +
                     " trajectories for " + std::to_string(own.size()) + " handles");
  std::vector<Trajectory> other;
  for (size_t p = 0; p < own.size(); ++p) other.push_back(resampled(from[p], own[p].frame_count()));
  std::vector<Trajectory> result;
  for (size_t p = 0; p < own.size(); ++p) {
    Trajectory target = other[p];
    if (options.align == Align::Shift)
      target.centres.rowwise() += (own[p].centres - target.centres).colwise().mean();
    else if (options.align == Align::Each)
      target = aligned(target, joint_alignment({other[p]}, {own[p]}, options.about));
    else
      target = aligned(target, joint_alignment(other, own, options.about));
    if (options.rotations)
      align_rotations(target, own[p]);
    else
      target.rotations = own[p].rotations;
    result.push_back(std::move(target));
  }
  return result;
}

}  // namespace batten
