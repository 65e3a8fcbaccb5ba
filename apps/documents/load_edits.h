// SPDX-License-Identifier: MPL-2.0
// Edit commands for supports, loads and painted areas of a scene.
#pragma once

#include <string>
#include <vector>

#include "batten/apps/documents/document_command.h"
#include "batten/core/eigen.h"

namespace batten {

/// Support of a curve, "clamped" or "pinned"; empty: none.
std::string support_of(const SceneText& scene, const std::string& line);

/// Sets the support of a curve, or removes it if `kind` is empty. A scene without [stress] gets one
/// with steel of 1 mm thickness. The result is empty if the scene does not list its supports as
/// inline tables.
std::vector<DocumentCommand> support_edits(const SceneText& scene, const std::string& line,
                                           const std::string& kind);

/// Adds a load, given as an inline table of [stress]. The scene must have [stress].
std::vector<DocumentCommand> stress_load_edits(const SceneText& scene, const std::string& load);

/// A support or load in a list of inline tables of [stress].
struct StressPart {
  std::string list;                           ///< "supports" or "loads"
  int item = 0;                               ///< 0-based index in the list
  std::string kind;                           ///< "clamped", "pressure", "force", …
  std::string of;                             ///< curve or face that it refers to; empty: none
  std::vector<SceneText::Value> values = {};  ///< keys and TOML values
};
/// All supports and loads of [stress].
std::vector<StressPart> stress_parts(const SceneText& scene);
/// Sets a key of a support or load. Empty if it no longer exists.
std::vector<DocumentCommand> stress_part_edits(const SceneText& scene, const StressPart& part,
                                               const std::string& key, const std::string& value);
/// Removes a support or load. Empty if it no longer exists.
std::vector<DocumentCommand> remove_stress_part(const SceneText& scene, const StressPart& part);

// Edits of painted areas of loads and stiffness fields.

/// One brush dab; the key `paint` of a load or stiffness field is a list of these.
struct BrushDab {
  Vec3 at = Vec3::Zero();  ///< position on the unloaded surface
  double radius = 0;
};

/// True if a table can be painted: a pressure, uniform load or stiffness field without `near`.
bool is_painted(const SceneText& scene, const SceneTable& table);

/// The painted dabs of a table; empty if it acts everywhere.
std::vector<BrushDab> painted_dabs(const SceneText& scene, const SceneTable& table);

/// Adds dabs with strength 1 to a table. `erases`: removes the dabs whose centre a new dab covers;
/// a table without dabs is removed.
std::vector<DocumentCommand> paint_edits(const SceneText& scene, const SceneTable& table,
                                         const std::vector<BrushDab>& dabs, bool erases);

/// Creates a painted table with value 0; `kind` is "pressure", "alpha" or "beta".
DocumentCommand new_paint(const std::string& name, const std::string& kind,
                          const std::vector<BrushDab>& dabs);

}  // namespace batten
