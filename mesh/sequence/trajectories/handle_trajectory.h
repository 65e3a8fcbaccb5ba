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
    PiecewiseLinear,  ///< minimise first differences (5): the change has a kink at keyframes
    Smooth            ///< minimise ∫ |x''|²: the change is smooth at keyframes
  };
  Smoothness smoothness = Smoothness::Smooth;
  InfluenceInterval influence;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;  ///< extrapolation of rotations
  std::vector<double> times;  ///< times of the frames, ascending; empty: frame numbers
};

/// Centroids c' of a handle in all F frames after an edit. They interpolate the given centroids at
/// keyframes, and their differences in time are those of the original centroids c, rotated:
///
///     min Σ_k Σ_{j=k±1} ‖ (c'_j - c'_k) - R_k (c_j - c_k) ‖²     (5)
///
/// R_k is the change of rotation in frame k, given for all frames. Let g be the cumulative sum of
/// (R_k + R_{k+1})/2 (c_{k+1} - c_k). Then (5) distributes the remainder x = c' - g evenly: it is
/// linear over the frames between two keyframes, so no system has to be solved. Smoothness::Smooth
/// uses the spline of least ∫ |x''|² through the keyframes instead, with zero slope at both ends.
/// Outside the keyframes x is constant. With an influence interval, c' = c outside it, and c' - c
/// starts and ends at its ends, with zero slope for Smooth.
///
/// If nothing changes, the result is c to the last bit. One rigid motion of all keyframes moves all
/// of c by it, and shifting a single keyframe shifts the whole trajectory. With `times`,
/// differences are taken per unit of time.
///
/// `keyframes`: 0-based frames, ascending. Throws InputError: no keyframes, keyframes or times that
/// do not ascend, frames out of range, an influence interval that does not contain all keyframes,
/// wrong numbers of rotations, centroids or times. O(F). Source: [Xu2007], section 5.
Points edited_centres(const Points& centres, const std::vector<Mat3>& rotations,
                      const std::vector<int>& keyframes, const Points& centres_at_keyframes,
                      const TrajectoryOptions& options = {});

/// Rigid motion p → motion(p) that an edit prescribes for a handle in one frame (0-based).
struct HandleKeyframe {
  int frame = 0;
  RigidMotion motion;
};

/// Trajectory of a handle after an edit. Changes of rotation come from interpolated_rotations(),
/// centroids from edited_centres(). Keyframes must ascend. Throws what these functions throw. O(F).
Trajectory edited(const Trajectory& trajectory, const std::vector<HandleKeyframe>& keyframes,
                  const TrajectoryOptions& options = {});

// Resampling and alignment of trajectories, to combine sequences.

/// Interpolation between frames.
enum class Resampling {
  Linear,
  Hermite  ///< KeyframeWeights with linear ends: no kinks, exact for parabolas in the interior
};

/// Resamples a trajectory to `frames` frames, from its first frame to its last. Frame k of n is
/// taken at k (F - 1)/(n - 1). Rotations are interpolated by logarithms relative to the previous
/// frame, so consecutive frames must differ by less than half a turn. If the number of frames is
/// unchanged, the result is bit-identical. Throws InputError: no frames, fewer than 1 requested.
/// O(F + n).
Trajectory resampled(const Trajectory& trajectory, int frames,
                     Resampling how = Resampling::Hermite);

/// Options of alignment().
struct AlignmentOptions {
  /// Restricts the rotation to this axis, so that a walk stays upright; empty: any rotation.
  std::optional<Vec3> about;
  /// Fits a scale as well; false: scale 1.
  bool scales = true;
  Resampling resampling = Resampling::Hermite;
};

/// Least-squares similarity x → s R x + t that maps the centres of `from` to those of `to`, frame
/// by frame. `from` is resampled first if its number of frames differs. Collinear centres get the
/// smallest rotation that fits; coincident ones are only translated. Throws InputError: no frames,
/// an `about` without direction. O(frames).
Similarity alignment(const Trajectory& from, const Trajectory& to,
                     const AlignmentOptions& options = {});

/// Applies a similarity to a trajectory: centres s R c + t, rotations R T Rᵀ (the same rotations in
/// a rotated reference frame).
Trajectory aligned(const Trajectory& trajectory, const Similarity& similarity);

/// Options of transferred().
struct MotionTransferOptions {
  /// How the trajectories of the other sequence are aligned with those of the handles.
  enum class Align {
    All,   ///< one similarity about `about`, common to all handles
    Each,  ///< one similarity about `about` per handle
    Shift  ///< one translation per handle: for handles with little motion of their own
  } align = Align::All;
  /// Axis of the rotation of the similarities; empty: any rotation.
  std::optional<Vec3> about = Vec3::UnitZ();
  bool rotations = true;  ///< true: transfer rotations; false: positions only
};

/// Transfers the motion of another sequence to handles: the trajectories `from`, resampled to the
/// frames of the handles and aligned with their own trajectories. Rotations are relative to the first
/// frame, in which both may be oriented differently; their mean orientation over all frames is
/// aligned instead. `from` and `own`: one trajectory per handle. The results are targets of a
/// PrescribedMotion. Throws InputError if the numbers of trajectories differ, and like alignment().
std::vector<Trajectory> transferred(const std::vector<Trajectory>& from,
                                    const std::vector<Trajectory>& own,
                                    const MotionTransferOptions& options = {});

}  // namespace batten
