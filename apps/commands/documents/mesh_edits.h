// Edits of a deform scene's words about parts of its mesh, as commands on its document.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/apps/commands/documents/document_view.h"

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

}  // namespace batten
