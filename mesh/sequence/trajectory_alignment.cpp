#include "batten/mesh/sequence/trajectory_alignment.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/rotations.h"

namespace batten {
namespace {

/// fit_similarity() among the rotations about one direction.
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

/// R_base exp(Σ w_j log R_baseᵀR_j): logarithms of what is near, which no full turn is in between.
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
    throw InputError("a trajectory of " + std::to_string(given) + " frames in " +
                     std::to_string(frames));
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
    throw InputError("alignment of a trajectory without frames");
  if (options.about && !(options.about->norm() > 0 && options.about->allFinite()))
    throw InputError("alignment: `about` is no direction");
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

}  // namespace batten
