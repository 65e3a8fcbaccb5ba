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

/// A support or load that [stress] has in a list in braces.
struct StressPart {
  std::string list;                           ///< "supports" or "loads"
  int item = 0;                               ///< in it, counted from 0
  std::string kind;                           ///< "clamped", "pressure", "force", …
  std::string of;                             ///< the line or region that it names; ""
  std::vector<SceneText::Value> values = {};  ///< its keys, as TOML
};
std::vector<StressPart> stress_parts(const SceneText& scene);
/// What gives a key of it another value, and what takes it away. Empty where it is not there any more.
std::vector<DocumentCommand> stress_part_edits(const SceneText& scene, const StressPart& part,
                                               const std::string& key, const std::string& value);
std::vector<DocumentCommand> remove_stress_part(const SceneText& scene, const StressPart& part);


// Edits of where loads and weights act, as commands on a scene's document: what a brush paints.

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
