// Edits of what a scene says of stresses, as commands on its document.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"

namespace batten {

/// The kind of support that a line has, "clamped" or "pinned"; "" for none.
std::string support_of(const SceneText& scene, const std::string& line);

/// What supports a line so, or, with "", no more. A scene without [stress] gets one of a millimetre of
/// steel. Empty where the scene states supports in another form than a list in braces.
std::vector<DocumentCommand> support_edits(const SceneText& scene, const std::string& line,
                                           const std::string& kind);

/// What adds a load, a table of [stress] in braces. The scene has [stress].
std::vector<DocumentCommand> stress_load_edits(const SceneText& scene, const std::string& load);

}  // namespace batten
