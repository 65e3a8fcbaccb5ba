// Handles with prescribed trajectories in many frames of a sequence, and the motion of the rest.
#pragma once

#include <memory>
#include <vector>

#include "batten/mesh/sequence/sequence_editor.h"

namespace batten {

/// Prescribed trajectories of some handles. Trajectories that were measured in the sequence
/// (trajectory_of()) and then changed are typical; plant_feet(), filtered() and transferred() give
/// others.
struct PrescribedMotion {
  std::vector<int> handles;  ///< indices of the handles, without repetition
  /// One trajectory per handle. Rotations are relative to the first frame of the edited sequence.
  std::vector<Trajectory> targets;
  /// One entry per frame: nonzero if the mesh of this frame is solved by iteration (keyframe), zero
  /// if it is interpolated between keyframes. Empty: all frames are keyframes.
  std::vector<char> is_keyframe;
};

/// Marks every n-th frame, the first and the last frame, and both ends of each range in which
/// `needed` is set, as PrescribedMotion::is_keyframe. `keyframe_interval`: n, at least 1. `needed`:
/// one per frame, or empty.
std::vector<char> keyframe_mask(int frames, int keyframe_interval,
                                const std::vector<char>& needed = {});

/// Mean translation of the prescribed handles relative to `frames`, per frame: F×3. `handles`: all
/// handles. O(frames · vertices).
Points mean_shift(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                  const PrescribedMotion& motion);

/// Adds handles to a prescribed motion that keep their rotations and follow their trajectory in
/// `frames`, translated per frame by the rows of `shifts` (F×3). Without such handles a body whose
/// feet alone are prescribed leans towards the higher foot. `handles`: all handles; `unrotated`:
/// indices of those to add. Throws InputError if one of them is prescribed already.
void add_unrotated_handles(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                           const std::vector<int>& unrotated, const Points& shifts,
                           PrescribedMotion& motion);

/// Opens the influence interval at an end of a sequence (`frames` frames) that is a keyframe, so
/// that the edit need not fade out there. `first_keyframe`, `last_keyframe`: 0-based.
void open_influence_at_ends(InfluenceInterval& influence, int frames, int first_keyframe,
                            int last_keyframe);

/// Creates the editor of a sequence whose handles follow a prescribed motion: its keyframes are
/// solved, SequenceEditor::frames() gives the result. Hard handles also move exactly as prescribed
/// between keyframes; soft ones (FrameConstraints::penalty_weight) are interpolated there.
///
/// `sequence`: the editor keeps a reference. `mesh`: its first frame, converted by prepare().
/// `constraints`: of all its handles, only those of the motion are constrained. Throws InputError (an
/// index or a number of frames that does not match) and whatever SequenceEditor throws.
std::unique_ptr<SequenceEditor> prescribed_motion_editor(const MeshSequence& sequence,
                                                         const TriangleMesh& mesh,
                                                         FrameConstraints constraints,
                                                         const PrescribedMotion& motion,
                                                         SequenceEditOptions options = {},
                                                         const Progress& progress = {});

}  // namespace batten
