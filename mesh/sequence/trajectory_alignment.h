// One trajectory laid over another one, to mix sequences.
#pragma once

#include <optional>

#include "batten/mesh/deform/similarity.h"
#include "batten/mesh/sequence/keyframe_weights.h"
#include "batten/mesh/sequence/rigid_motion.h"

namespace batten {

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
