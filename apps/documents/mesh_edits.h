// SPDX-License-Identifier: MPL-2.0
// Edit commands for deform scenes and sequence scenes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/documents/document_command.h"
#include "batten/apps/documents/document_view.h"
#include "batten/core/eigen.h"

namespace batten {

/// Use of a part's vertices. Interest: region of interest, outside of which only handles move.
enum class PartUse { Free, Fixed, Handle, Rigid, TranslationOnly, Interest };

/// Use of a part in the last edit of a scene.
PartUse use_of(const SceneText& scene, const std::string& part);

/// Changes the use of a part, and removes its previous use. Wildcards in lists of features are
/// expanded first. A set of the mesh file is made a selection first, and a missing [[edit]] is
/// created.
std::vector<DocumentCommand> use_edits(const SceneText& scene, const MeshView& mesh,
                                       const std::string& part, PartUse use);

/// Creates a selection of nodes by number, or adds nodes to an existing one.
DocumentCommand nodes_edit(const SceneText& scene, const std::string& name,
                           const std::vector<long>& labels);
/// The node numbers listed in a selection.
std::vector<long> nodes_of(const SceneText& scene, const std::string& name);

// Edits of keyframes of a sequence scene.

/// Sets the motion of a handle in one frame (1-based) of the last operation: a translation, and a
/// rotation vector whose length is the angle in degrees. An operation of type "keyframes" is added if the last one
/// has another type, and a keyframe if the frame has none.
std::vector<DocumentCommand> keyframe_edits(const SceneText& scene, int frame,
                                            const std::string& handle, const Vec3& shift,
                                            const Vec3& rotation_vector);

/// Makes the whole sequence follow a curve through these points, by a new `path` operation or by
/// changing the last operation if it is one.
DocumentCommand path_edit(const SceneText& scene, const std::vector<Vec3>& through);
/// The points of the last path; empty if there is none.
std::vector<Vec3> path_of(const SceneText& scene);

/// Makes a selection a handle.
std::vector<DocumentCommand> sequence_handle_edits(const SceneText& scene,
                                                   const std::string& selection);

}  // namespace batten
