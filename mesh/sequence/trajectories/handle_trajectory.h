// Where a handle goes in all frames when keyframes say where it is in some.
#pragma once

#include <optional>
#include <vector>

#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/sequence/trajectories/rigid_motion.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

struct TrajectoryOptions {
  enum class Smoothness {
    PiecewiseLinear,  ///< first differences (5): the change has a kink at keyframes
    Smooth            ///< ∫ |x''|²: it has none
  };
  Smoothness smoothness = Smoothness::Smooth;
  InfluenceInterval influence;
  KeyframeExtrapolation ends = KeyframeExtrapolation::None;  ///< of the rotations
  std::vector<double> times;  ///< of the frames, ascending; none: their numbers
};

/// New centroids c' of a handle in all F frames, equal to given ones at keyframes, whose
/// differences in time are those of c, turned:
///
///     min Σ_k Σ_{j=k±1} ‖ (c'_j - c'_k) - R_k (c_j - c_k) ‖²     (5)
///
/// R_k: the change of rotation in frame k, of all frames. With g the sum of (R_k + R_{k+1})/2
/// (c_{k+1} - c_k), the rest x = c' - g is what (5) makes as even as it can: straight over the
/// frames between two keyframes, without a system to solve. Smooth: the spline of least ∫ |x''|²
/// through keyframes, which begins and ends with slope zero. Outside of the keyframes x is
/// constant; with an influence c' = c outside of that, and c' - c begins and ends there, with slope
/// zero in the smooth case.
///
/// Nothing changed gives c to the last bit; one rigid motion of all keyframes moves all of c by it;
/// one keyframe that is shifted shifts the whole. With times differences count per time.
///
/// Throws InputError: no keyframes, keyframes or times that do not ascend, frames that are not
/// there, an influence that does not hold all keyframes, other numbers of rotations, centroids or
/// times. O(F). Source: Xu et al. 2007, section 5.
Points edited_centres(const Points& centres, const std::vector<Mat3>& rotations,
                      const std::vector<int>& keyframes, const Points& centres_at_keyframes,
                      const TrajectoryOptions& options = {});

/// What an edit does to a handle in one frame: p → motion(p).
struct HandleKeyframe {
  int frame = 0;
  RigidMotion motion;
};

/// The trajectory of a handle after an edit: changes of rotation by `interpolated_rotations`, centroids
/// by `edited_centres`. Keyframes ascend. Throws what these throw. O(F).
Trajectory edited(const Trajectory& trajectory, const std::vector<HandleKeyframe>& keyframes,
                  const TrajectoryOptions& options = {});


// One trajectory laid over another one, to mix sequences.

/// How values between frames come about.
enum class Resampling {
  Linear,
  Hermite  ///< `KeyframeWeights` with linear ends: no kinks, exact for parabolas inside
};

/// The same motion in another number of frames, from the first frame to the last: frame k of n is
/// at k (F - 1)/(n - 1) of F. Rotations by logarithms relative to the frame before: two frames turn
/// by less than half a turn. As many frames as before come back to the last bit. Throws InputError:
/// no frames, fewer than 1 asked for. O(F + n).
Trajectory resampled(const Trajectory& trajectory, int frames,
                     Resampling how = Resampling::Hermite);

struct AlignmentOptions {
  /// Turns about this direction only: a walk stays upright. Otherwise about any.
  std::optional<Vec3> about;
  bool scales = true;
  Resampling resampling = Resampling::Hermite;
};

/// The similarity x → s R x + t that brings the centres of `from` nearest to those of `to`, in the
/// least-squares sense over the frames; `from` is resampled first where it has another number of
/// frames. Centres on one line turn by the smallest rotation that fits; those that stand still are
/// shifted only. Throws InputError: no frames, `about` that is no direction. O(frames).
Similarity alignment(const Trajectory& from, const Trajectory& to,
                     const AlignmentOptions& options = {});

/// Centres s R c + t; turns R T Rᵀ, the same rotations seen from a frame of reference that is
/// turned.
Trajectory aligned(const Trajectory& trajectory, const Similarity& similarity);

}  // namespace batten
