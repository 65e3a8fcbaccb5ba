// Handles that are told where to be in many frames, and what the rest of the mesh does then.
#pragma once

#include <memory>
#include <vector>

#include "batten/apps/commands/sequences/sequence_parts.h"

namespace batten {

/// Trajectories that some handles shall have.
struct PrescribedMotion {
  std::vector<int> handles;  ///< of the parts
  std::vector<Trajectory> target_trajectory;
  std::vector<char> prescribed;  ///< of each frame, whether it is a keyframe; empty: every one
};

/// Warnings about handles some of whose nodes are fixed: these stay. Throws InputError for a handle
/// that has no others, which is told to move and cannot.
std::vector<std::string> warn_of_fixed_handle_nodes(const SequenceParts& parts,
                                                    const std::vector<int>& handles,
                                                    const std::vector<int>& fixed);

/// Every so many frames, and the first and last of each run where `needed` is set.
std::vector<char> keyframe_mask(int frames, int keyframe_interval, const std::vector<char>& needed);

/// The editor of a step with the handles of these numbers, whose first and last keyframes are in
/// these frames, counted from 0. An influence that ends with the sequence at a keyframe is open.
std::shared_ptr<SequenceEditor> editor_for(const SequenceOperation& step,
                                           const PreparedSequence& from, const SequenceParts& parts,
                                           const std::vector<int>& handles,
                                           const std::vector<int>& fixed, int first_key,
                                           int last_key);

/// Frames by an editor whose keyframes are set.
StepResult result_of(const PreparedSequence& from, std::shared_ptr<SequenceEditor> editor);

/// Both for handles that are told.
StepResult apply_prescribed_motion(const SequenceOperation& step, const PreparedSequence& from,
                                   const SequenceParts& parts, const PrescribedMotion& prescribed,
                                   const std::vector<int>& fixed, const Progress& progress);

/// Feet of a step: where they stand, found on `before`.
struct FootTracks {
  std::vector<int> handles;
  std::vector<Trajectory> before;
  std::vector<std::vector<FootContact>> prints;  ///< of each foot
};
FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<LocatedString>& feet,
                     const FootContactSearch& search, std::vector<std::string>& warnings);

/// For the report; how they slip afterwards is measured on the finished frames.
std::vector<SequenceReport::Foot> foot_reports(const SequenceScene& scene,
                                               const SequenceOperation& step,
                                               const FootTracks& tracks, double size);

/// Feet planted: in each frame of print j of foot f the centroid is exactly at to[f][j].at, turned
/// as it was, and as the print was; in between the change goes over smoothly. `moved`: trajectories
/// in the sequence that the step begins with.
PrescribedMotion plant_feet(const SequenceScene& scene, const SequenceOperation& step,
                            const FootTracks& tracks, const std::vector<Trajectory>& moved,
                            const std::vector<std::vector<FootContact>>& to,
                            const std::vector<double>& times);

/// Adds handles that keep their turns and go where they go in `from`, each frame shifted by the row of
/// `shifts` (F×3). A body whose feet alone are told leans to the foot that stands higher.
void add_upright_handles(const SequenceScene& scene, const PreparedSequence& from,
                         const SequenceParts& parts, const std::vector<LocatedString>& names,
                         const Points& shifts, PrescribedMotion& prescribed);

/// By how much the told handles are elsewhere than in `from`, in the mean: F×3.
Points mean_shift(const PreparedSequence& from, const SequenceParts& parts,
                  const PrescribedMotion& prescribed);

}  // namespace batten
