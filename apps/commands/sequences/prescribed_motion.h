// Handles with prescribed positions in many frames, and the motion of the rest of the mesh.
#pragma once

#include <memory>
#include <vector>

#include "batten/apps/commands/sequences/sequence_parts.h"

namespace batten {

/// Prescribed trajectories of some handles.
struct PrescribedMotion {
  std::vector<int> handles;  ///< indices into SequenceParts::handles
  std::vector<Trajectory> target_trajectory;
  std::vector<char> prescribed;  ///< per frame: true if it is a keyframe; empty: all frames
};

/// Warnings about handles with some fixed nodes, which stay fixed. Throws InputError if all nodes
/// of a handle are fixed, since it cannot follow its motion.
std::vector<std::string> warn_of_fixed_handle_nodes(const SequenceParts& parts,
                                                    const std::vector<int>& handles,
                                                    const std::vector<int>& fixed);

/// Marks every n-th frame, the first and the last frame, and both ends of each range in which
/// `needed` is set.
std::vector<char> keyframe_mask(int frames, int keyframe_interval, const std::vector<char>& needed);

/// Creates the editor of a step for the given handles. `first_key`, `last_key`: first and last
/// keyframe, 0-based. If the last frame is a keyframe, the influence interval is open-ended;
/// likewise at the first frame.
std::shared_ptr<SequenceEditor> editor_for(const SequenceOperation& step,
                                           const PreparedSequence& from, const SequenceParts& parts,
                                           const std::vector<int>& handles,
                                           const std::vector<int>& fixed, int first_key,
                                           int last_key);

/// The frames of an editor whose keyframes are set.
StepResult result_of(const PreparedSequence& from, std::shared_ptr<SequenceEditor> editor);

/// Both for prescribed handles: creates the editor, and computes the frames.
StepResult apply_prescribed_motion(const SequenceOperation& step, const PreparedSequence& from,
                                   const SequenceParts& parts, const PrescribedMotion& prescribed,
                                   const std::vector<int>& fixed, const Progress& progress);

/// Feet of a step, with their contacts detected in `before`.
struct FootTracks {
  std::vector<int> handles;
  std::vector<Trajectory> before;
  std::vector<std::vector<FootContact>> prints;  ///< foot contacts of each foot
};
/// Detects the contacts of feet. `warnings` receives remarks.
FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<LocatedString>& feet,
                     const FootContactSearch& search, std::vector<std::string>& warnings);

/// Report entries of feet. The remaining foot skate is measured later, on the finished frames.
std::vector<SequenceReport::Foot> foot_reports(const SequenceScene& scene,
                                               const SequenceOperation& step,
                                               const FootTracks& tracks, double size);

/// Plants feet: in each frame of contact j of foot f, the centroid is exactly to[f][j].at. The foot
/// is rotated by the change of rotation between the original contact and to[f][j]. Between contacts
/// the change blends smoothly. `moved`: trajectories at the start of the step.
PrescribedMotion plant_feet(const SequenceScene& scene, const SequenceOperation& step,
                            const FootTracks& tracks, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times);

/// Adds handles that keep their rotations and follow their trajectory in `from`, translated per
/// frame by the rows of `shifts` (F×3). Without them, a body whose feet alone are prescribed leans
/// towards the higher foot.
void add_upright_handles(const SequenceScene& scene, const PreparedSequence& from,
                         const SequenceParts& parts, const std::vector<LocatedString>& names,
                         const Points& shifts, PrescribedMotion& prescribed);

/// Mean translation of the prescribed handles relative to `from`, per frame: F×3.
Points mean_shift(const PreparedSequence& from, const SequenceParts& parts,
                  const PrescribedMotion& prescribed);

}  // namespace batten
