// SPDX-License-Identifier: MPL-2.0
// Prescribed trajectories of handles in a sequence, and editors of sequences that follow them.
#pragma once

#include <memory>
#include <vector>

#include "batten/mesh/sequence/sequence_editor.h"

namespace batten {

/// Prescribed trajectories of some handles. Typically, a trajectory is measured in the sequence by
/// trajectory_of() and then modified, or it is computed by plant_feet(), filtered() or
/// transferred().
struct PrescribedMotion {
  std::vector<int> handles;  ///< indices of the prescribed handles, without repetition
  /// Trajectory of each prescribed handle. Rotations are relative to the first frame of the
  /// sequence that is edited.
  std::vector<Trajectory> targets;
  /// One flag per frame: nonzero if the frame is a keyframe, whose mesh is computed by iteration;
  /// zero if the frame is interpolated between keyframes. Empty: all frames are keyframes.
  std::vector<char> is_keyframe;
};

/// Creates the keyframe flags of `frames` frames; see PrescribedMotion::is_keyframe. Keyframes are
/// every n-th frame, the first and the last frame, and the first and last frame of each range of
/// frames in which `needed` is nonzero. `keyframe_interval`: n, at least 1. `needed`: one flag per
/// frame, or empty.
std::vector<char> keyframe_mask(int frames, int keyframe_interval,
                                const std::vector<char>& needed = {});

/// Mean displacement of the prescribed handles in each of F frames, relative to their positions in
/// `frames`, F×3. `handles`: all handles. O(frames · vertices).
Points mean_shift(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                  const PrescribedMotion& motion);

/// Adds handles to a prescribed motion that keep their original rotations and are only translated.
/// In each of the F frames, their trajectory in `frames` is translated by a row of `shifts` (F×3),
/// for example of mean_shift(). Use this function if only the feet of a body are prescribed; the
/// body would otherwise lean towards the higher foot. `handles`: all handles. `unrotated`: indices
/// of the handles to add. Throws InputError if one of these handles is already prescribed.
void add_unrotated_handles(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                           const std::vector<int>& unrotated, const Points& shifts,
                           PrescribedMotion& motion);

/// Removes each bound of an influence interval that coincides with a keyframe at an end of the
/// sequence, so that the edit does not fade out there. `frames`: number of frames.
/// `first_keyframe`, `last_keyframe`: 0-based frames of the first and last keyframe.
void open_influence_at_ends(InfluenceInterval& influence, int frames, int first_keyframe,
                            int last_keyframe);

/// Creates an editor for a sequence whose handles follow a prescribed motion, and computes the
/// keyframes; SequenceEditor::frames() then gives the edited frames. Between keyframes, hard
/// handles move exactly as prescribed, while soft handles (FrameConstraints::penalty_weight) are
/// interpolated.
///
/// `sequence`: the editor keeps a reference to it. `mesh`: the first frame of the sequence,
/// converted by prepare(). `constraints`: handles that are not prescribed by `motion` are
/// unconstrained. Throws InputError if a handle index or the number of frames does not match, and
/// the exceptions of SequenceEditor.
std::unique_ptr<SequenceEditor> prescribed_motion_editor(const MeshSequence& sequence,
                                                         const TriangleMesh& mesh,
                                                         FrameConstraints constraints,
                                                         const PrescribedMotion& motion,
                                                         SequenceEditOptions options = {},
                                                         const Progress& progress = {});

}  // namespace batten
