// Edits of a deform scene's words about parts of its mesh, as commands on its document.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_view.h"
#include "batten/core/eigen.h"

namespace batten {

/// What the vertices of a part are for. Interest: they are in the region of interest, and of all other
/// vertices only handles move.
enum class PartUse { Free, Fixed, Handle, Rigid, TranslationOnly, Interest };

/// What the last edit of a scene takes a part for.
PartUse use_of(const SceneText& scene, const std::string& part);

/// What makes the scene take a part for something else: the words that say what it is for now go. A
/// list of features with '*' becomes the names that it means, without this one. A set of the mesh file
/// becomes a selection first, and where there is no [[edit]] there is one then.
std::vector<DocumentCommand> use_edits(const SceneText& scene, const MeshView& mesh,
                                       const std::string& part, PartUse use);

/// A selection of nodes by their numbers, or more nodes of one that is there.
DocumentCommand nodes_edit(const SceneText& scene, const std::string& name,
                           const std::vector<long>& labels);
/// The numbers that a selection states.
std::vector<long> nodes_of(const SceneText& scene, const std::string& name);


// Edits of a sequence scene's keyframes, as commands on its document.

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
