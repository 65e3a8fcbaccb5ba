// Edits of a scene's words about lines and regions, as commands on its document.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"
#include "batten/io/report/network_report.h"

namespace batten {

/// What makes a line a crease or smooth ("crease", "smooth", "tangent", "curvature"), or, without a
/// word, what the surfaces at it say: the words about it in any [[join]] are changed or taken out.
std::vector<DocumentCommand> join_edits(const SceneText& scene, const std::string& line,
                                        const std::optional<std::string>& kind);

/// What asks for one of the alternatives of a choice: a [[region]] for each loop that is not there yet,
/// and no surface in loops that were chosen and are not among them.
std::vector<DocumentCommand> alternative_edits(const NetworkReport::Choice& choice,
                                               int alternative);

}  // namespace batten
