// Edits of a sequence scene's keyframes, as commands on its document.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/core/eigen.h"

namespace batten {

/// What makes a handle move in one frame (from 1), in the last step, by a shift and a turn (a vector along
/// its axis, as long as its angle in degrees): a step of keyframes is added where the last one is of
/// another kind, a keyframe where the step has none there.
std::vector<DocumentCommand> keyframe_edits(const SceneText& scene, int frame,
                                            const std::string& handle, const Vec3& shift,
                                            const Vec3& rotation_vector);

/// What makes the whole sequence go along a curve through these points: a step of the kind `path`, or
/// another curve for the last one of this kind.
DocumentCommand path_edit(const SceneText& scene, const std::vector<Vec3>& through);
/// The points of the last path; none where there is none.
std::vector<Vec3> path_of(const SceneText& scene);

/// What makes a handle of a selection.
std::vector<DocumentCommand> sequence_handle_edits(const SceneText& scene,
                                                   const std::string& selection);

}  // namespace batten
