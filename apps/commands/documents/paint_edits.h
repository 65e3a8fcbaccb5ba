// Edits of where loads and weights act, as commands on a scene's document: what a brush paints.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/commands/documents/document_command.h"

namespace batten {

/// What a brush leaves at one place: the key `paint` of a load or weight has a list of these.
struct BrushDab {
  Vec3 at = Vec3::Zero();  ///< on the surface without loads
  double radius = 0;
};

/// Whether a brush paints it: a pressure, a uniform load or a weight that does not act near a line.
bool is_painted(const SceneText& scene, const SceneTable& table);

/// What is painted of a table; none where it acts everywhere.
std::vector<BrushDab> painted_dabs(const SceneText& scene, const SceneTable& table);

/// Adds dabs to what is painted of a table, with the strength 1. `erases`: takes away those whose
/// middle a dab covers; where none is left, the table goes.
std::vector<DocumentCommand> paint_edits(const SceneText& scene, const SceneTable& table,
                                         const std::vector<BrushDab>& dabs, bool erases);

/// A new table that acts where it is painted, with the value 0: `kind` is "pressure", "alpha" or "beta".
DocumentCommand new_paint(const std::string& name, const std::string& kind,
                          const std::vector<BrushDab>& dabs);

}  // namespace batten
