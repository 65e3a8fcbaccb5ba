// Handles with prescribed trajectories, as steps of a sequence scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/apps/commands/sequences/sequence_parts.h"
#include "batten/mesh/sequence/foot_plants.h"
#include "batten/mesh/sequence/prescribed_motion.h"

namespace batten {

/// Warnings about handles with some fixed nodes, which stay fixed. Throws InputError if all nodes
/// of a handle are fixed, since it cannot follow its motion.
std::vector<std::string> warn_of_fixed_handle_nodes(const SequenceParts& parts,
                                                    const std::vector<int>& handles,
                                                    const std::vector<int>& fixed);

/// The constraints of a step: all handles and features of the scene.
FrameConstraints constraints_of(const SequenceOperation& step, const SequenceParts& parts,
                                const std::vector<int>& fixed);

/// The frames of an editor whose keyframes are set.
StepResult result_of(const PreparedSequence& from, std::shared_ptr<SequenceEditor> editor);

/// The frames of a step whose handles follow a prescribed motion.
StepResult apply_prescribed_motion(const SequenceOperation& step, const PreparedSequence& from,
                                   const SequenceParts& parts, const PrescribedMotion& prescribed,
                                   const std::vector<int>& fixed, const Progress& progress);

/// Detects the contacts of feet. `warnings` receives remarks.
FootTracks find_feet(const SequenceScene& scene, const MeshSequence& before,
                     const SequenceParts& parts, const std::vector<LocatedString>& feet,
                     const FootContactSearch& search, std::vector<std::string>& warnings);

/// Throws InputError if no foot is on the ground in any frame.
void require_contacts(const SequenceScene& scene, const SequenceOperation& step,
                      const FootTracks& tracks);

/// Report entries of feet. The remaining foot skate is measured later, on the finished frames.
std::vector<SequenceReport::Foot> foot_reports(const SequenceOperation& step,
                                               const FootTracks& tracks, double size);

/// Adds the handles of the key `unrotated`; see add_unrotated_handles().
void add_upright_handles(const SequenceScene& scene, const PreparedSequence& from,
                         const SequenceParts& parts, const std::vector<LocatedString>& names,
                         const Points& shifts, PrescribedMotion& prescribed);

}  // namespace batten
