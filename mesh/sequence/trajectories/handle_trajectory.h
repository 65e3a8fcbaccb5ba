// SPDX-License-Identifier: MPL-2.0
// Trajectories of handles after a keyframe edit, and resampling and alignment of trajectories.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"

namespace batten {

/// Options of edited_centres() and edited().
struct TrajectoryOptions {
  enum class Smoothness {
    /// Minimises first differences (equation (5) of edited_centres()). The change of the trajectory
    /// is continuous, but its velocity jumps at keyframes.
    PiecewiseLinear,
    /// Minimises second derivatives. The velocity of the change is continuous at keyframes, too.
    Smooth
  };
  Smoothness smoothness = Smoothness::Smooth;
  InfluenceInterval influence;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;  ///< extrapolation of rotation changes
  std::vector<double> times;  ///< times of the frames, ascending; empty: frame numbers
};

/// Centroids c' of a handle in all F frames after an edit, F×3. They interpolate the prescribed
/// centroids at keyframes. Their differences in time approximate those of the original centroids c,
/// rotated by the change of rotation R_k in each frame k:
///
///     min Σ_k Σ_{j=k±1} ‖ (c'_j - c'_k) - R_k (c_j - c_k) ‖²     (5)
///
/// Let g_k be the cumulative sum of (R_k + R_{k+1})/2 (c_{k+1} - c_k). In the solution of (5), the
/// remainder x = c' - g is linear over the frames between two keyframes, so no system has to be
/// solved. For Smoothness::Smooth, x is instead the cubic spline through the keyframes that
/// minimises ∫ |x''|², with zero slope at both ends. Before the first and after the last keyframe x
/// is constant. If there is an influence interval, c' = c outside this interval, and c' - c is 0 at
/// the ends of the interval, with zero slope for Smooth.
///
/// If the edit changes nothing, the result is bit-identical to c. If all keyframes are moved by the
/// same rigid motion, so are all centroids; if the only keyframe is translated, so are all
/// centroids. If TrajectoryOptions::times is given, differences are taken per unit of time.
///
/// `centres`: original centroids c (F×3). `rotations`: R_k of all frames. `keyframes`: 0-based
/// frames, ascending. `centres_at_keyframes`: prescribed centroids, one row per keyframe. Throws
/// InputError if there are no keyframes, keyframes or times do not ascend, a frame is out of range,
/// the influence interval does not contain all keyframes, or the number of rotations, centroids or
/// times is wrong. O(F). Reference: [Xu2007], section 5.
Points edited_centres(const Points& centres, const std::vector<Mat3>& rotations,
                      const std::vector<int>& keyframes, const Points& centres_at_keyframes,
                      const TrajectoryOptions& options = {});

/// Rigid motion p → motion(p) that an edit prescribes for a handle in one frame.
struct HandleKeyframe {
  int frame = 0;
  RigidMotion motion;
};

/// Trajectory of a handle after an edit. The changes of rotation are computed by
/// interpolated_rotations(), the centroids by edited_centres(). `keyframes`: in ascending order.
/// Throws the exceptions of interpolated_rotations() and edited_centres(). O(frames).
Trajectory edited(const Trajectory& trajectory, const std::vector<HandleKeyframe>& keyframes,
                  const TrajectoryOptions& options = {});

// Resampling and alignment of trajectories, to combine sequences.

/// Interpolation method for positions between frames.
enum class Resampling {
  Linear,  ///< piecewise linear
  Hermite  ///< cubic Hermite, see KeyframeWeights: smooth, and exact for parabolas except at ends
};

/// Resamples a trajectory from F to n = `frames` evenly spaced frames. Frame k of the result is the
/// original trajectory at frame k (F - 1)/(n - 1). Rotations are interpolated by the logarithms of
/// the rotations between consecutive frames, which must be by less than half a turn. If n = F, the
/// result is bit-identical. Throws InputError if the trajectory has no frames or n is below 1. O(F
/// + n).
Trajectory resampled(const Trajectory& trajectory, int frames,
                     Resampling how = Resampling::Hermite);

/// Options of alignment().
struct AlignmentOptions {
  /// Rotation axis to which the rotation is restricted, so that a walk stays upright, for example;
  /// empty: the rotation is not restricted.
  std::optional<Vec3> about;
  /// True: the scale is fitted; false: the scale is 1.
  bool scales = true;
  Resampling resampling = Resampling::Hermite;
};

/// Least-squares similarity x → s R x + t that maps the centres of trajectory `from` to those of
/// `to`, frame by frame. If the numbers of frames differ, `from` is resampled first. For collinear
/// centres, R is the smallest rotation that fits; for coincident centres, R is the identity. Throws
/// InputError if a trajectory has no frames or AlignmentOptions::about is zero. O(frames).
Similarity alignment(const Trajectory& from, const Trajectory& to,
                     const AlignmentOptions& options = {});

/// Applies a similarity x → s R x + t to a trajectory. The centres c become s R c + t. The
/// rotations T become R T Rᵀ, that is, the same rotations in a rotated coordinate system.
Trajectory aligned(const Trajectory& trajectory, const Similarity& similarity);

/// Options of transferred().
struct MotionTransferOptions {
  /// How the transferred trajectories are aligned with the original trajectories of the handles.
  enum class Align {
    All,   ///< one similarity aligns all handles
    Each,  ///< one similarity per handle
    Shift  ///< one translation per handle; for handles that originally hardly move
  } align = Align::All;
  /// Rotation axis to which the rotations of the similarities are restricted; empty: no
  /// restriction.
  std::optional<Vec3> about = Vec3::UnitZ();
  bool rotations = true;  ///< true: transfers rotations and positions; false: positions only
};

/// Transfers the motion of another sequence to handles. The trajectories `from` of the other
/// sequence are resampled to the number of frames of the trajectories `own` of the handles, and
/// aligned with them. Both lists contain one trajectory per handle. Since a handle may have
/// different orientations in the first frames of the two sequences, rotations are aligned by their
/// means over all frames. Use the results as PrescribedMotion::targets. Throws InputError if the
/// numbers of trajectories differ, and the exceptions of alignment().
std::vector<Trajectory> transferred(const std::vector<Trajectory>& from,
                                    const std::vector<Trajectory>& own,
                                    const MotionTransferOptions& options = {});

}  // namespace batten
