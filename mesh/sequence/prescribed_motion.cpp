// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/prescribed_motion.h"

#include <algorithm>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void check(const PrescribedMotion& motion, int handles, int frames) {
  if (motion.targets.size() != motion.handles.size())
    throw InputError("prescribed motion: found " + std::to_string(motion.targets.size()) +
                     " trajectories for " + std::to_string(motion.handles.size()) + " handles");
  for (const int h : motion.handles)
    if (h < 0 || h >= handles)
      throw InputError("prescribed motion: found handle " + std::to_string(h) +
                       ", expected one of 0 to " + std::to_string(handles - 1));
  if (!motion.is_keyframe.empty() && isize(motion.is_keyframe) != frames)
    throw InputError("prescribed motion: found keyframes of " +
                     std::to_string(motion.is_keyframe.size()) + " frames, expected " +
                     std::to_string(frames));
}

}  // namespace

std::vector<char> keyframe_mask(int frames, int keyframe_interval,
                                const std::vector<char>& needed) {
  std::vector<char> mask(frames, 0);
  for (int k = 0; k < frames; k += keyframe_interval) mask[k] = 1;
  if (frames > 0) mask.back() = 1;
  for (int k = 0; k < frames && !needed.empty(); ++k)
    if (needed[k] && (k == 0 || k + 1 == frames || !needed[k - 1] || !needed[k + 1])) mask[k] = 1;
  return mask;
}

Points mean_shift(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                  const PrescribedMotion& motion) {
  Points sum = Points::Zero(isize(frames), 3);
  for (size_t h = 0; h < motion.handles.size(); ++h) {
    const Trajectory before = trajectory_of(frames, handles[motion.handles[h]].vertices);
    sum +=
        (motion.targets[h].centres - before.centres) / static_cast<double>(motion.handles.size());
  }
  return sum;
}

void add_unrotated_handles(const std::vector<Points>& frames, const std::vector<Handle>& handles,
                           const std::vector<int>& unrotated, const Points& shifts,
                           PrescribedMotion& motion) {
  for (const int h : unrotated) {
    if (std::find(motion.handles.begin(), motion.handles.end(), h) != motion.handles.end())
      throw InputError("the handle '" + handles[h].name +
                       "' has a prescribed motion already, expected another handle");
    Trajectory target = trajectory_of(frames, handles[h].vertices);
    target.centres += shifts;
    motion.handles.push_back(h);
    motion.targets.push_back(std::move(target));
  }
}

void open_influence_at_ends(InfluenceInterval& influence, int frames, int first_keyframe,
                            int last_keyframe) {
  if (first_keyframe == 0 && influence.from == 0) influence.from.reset();
  const int last = frames - 1;
  if (last_keyframe == last && influence.to == last) influence.to.reset();
}

std::unique_ptr<SequenceEditor> prescribed_motion_editor(
    const MeshSequence& sequence, const TriangleMesh& mesh, FrameConstraints constraints,
    const PrescribedMotion& motion, SequenceEditOptions options, const Progress& progress) {
  const int frames = sequence.frame_count();
  check(motion, isize(constraints.handles), frames);
  const bool hard = !constraints.penalty_weight;
  std::vector<Handle> handles;
  for (const int h : motion.handles) handles.push_back(constraints.handles[h]);
  constraints.handles = std::move(handles);
  open_influence_at_ends(options.influence, frames, 0, frames - 1);
  auto editor = std::make_unique<SequenceEditor>(sequence, mesh, std::move(constraints), options);
  std::vector<std::vector<RigidMotion>> motions;
  for (size_t h = 0; h < motion.handles.size(); ++h)
    motions.push_back(motions_between(editor->trajectories_before()[h], motion.targets[h]));
  std::vector<SequenceKeyframe> keys;
  for (int k = 0; k < frames; ++k) {
    if (!motion.is_keyframe.empty() && !motion.is_keyframe[k]) continue;
    SequenceKeyframe key{k, {}};
    for (const auto& of_handle : motions) key.handles.push_back(HandlePose{of_handle[k], false});
    keys.push_back(std::move(key));
  }
  editor->set_keyframes(std::move(keys), progress);
  if (hard) editor->set_motions(std::move(motions));  // exact motion between keyframes
  return editor;
}

}  // namespace batten
