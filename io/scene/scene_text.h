// SPDX-License-Identifier: MPL-2.0
// Edits the text of a scene file in place, preserving its layout and comments.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// Identifies one table of a scene by its kind and name. [skin] is {"skin", ""}; the [[load]] named
/// "push" is {"load", "push"}. Unnamed tables are identified by their position: {"join", "#2"} is
/// the second [[join]]. {} is the top level of the file. A nested table such as [[edit.handle]] is
/// identified by both names: {"edit.handle", "edit 1.right"}.
struct SceneTable {
  std::string kind = {}, name = {};
  bool operator==(const SceneTable&) const = default;
};

/// The text of a scene, with edits that change only the affected characters. The comments, order,
/// white space and line ends of all other text are preserved.
///
/// Values are given as TOML: `"text"`, `[0, 0, 1]`, `{ point = [1, 2, 3] }`. SceneText does not
/// check whether a key is valid in its table; parse_scene() does. An edit throws InputError
/// ("FILE:LINE:COLUMN: …") and leaves the text unchanged if a value is not TOML, or if a table or
/// key does not exist. Inline tables, `load = [{ … }]`, can also be edited. Cost: O(bytes) per
/// edit.
class SceneText {
 public:
  /// `file` is used in messages only. Throws InputError if the text is not TOML.
  explicit SceneText(std::string text, std::filesystem::path file = {});

  /// The text of the scene after all edits so far.
  const std::string& text() const { return text_; }
  /// The tables of the scene in file order, including nested tables such as [[edit.handle]].
  const std::vector<SceneTable>& tables() const { return names_; }
  /// True if the scene contains the given table.
  bool has(const SceneTable& table) const;
  /// A key and its value, both as written in the scene file.
  using Value = std::pair<std::string, std::string>;
  /// The keys and values of a table, in file order.
  std::vector<Value> values(const SceneTable& table) const;
  /// The keys and values of all tables of the scene, in file order, starting with the top level.
  std::vector<std::pair<SceneTable, std::vector<Value>>> all_values() const;
  /// The value of a key of a table, as written in the scene file; empty if the key does not exist.
  std::string value(const SceneTable& table, const std::string& key) const;

  /// The strings in the value of a key: a list of strings, or a single string. Empty for values of
  /// other types.
  std::vector<std::string> strings(const SceneTable& table, const std::string& key) const;

  /// Replaces the value of a key of a table. A missing key is added at the end of its table; a
  /// missing table [KIND] is created.
  void set(const SceneTable& table, const std::string& key, const std::string& value);
  /// Replaces one element of the list that is the value of a key; `item` is the 0-based index.
  void set_item(const SceneTable& table, const std::string& key, int item,
                const std::string& value);
  /// Removes a key and its value from a table.
  void erase(const SceneTable& table, const std::string& key);
  /// Adds a table [[KIND]] after the last table of this kind, or at the end of the file. `table` is
  /// the new table as an inline table: `{ name = "push", type = "point", … }`. An [[edit.handle]]
  /// is added to the last [[edit]]. The kind "[stress]", with brackets, creates the single table
  /// [stress]. The result identifies the new table.
  SceneTable add(const std::string& kind, const std::string& table);
  /// Removes a table and the comments directly above it.
  void remove(const SceneTable& table);
  /// Sets the value of a parameter of the scene (see Scene::parameters()) in the key that defines
  /// the parameter. A time-dependent parameter becomes constant.
  void set_parameter(const std::string& parameter, double value);

  /// TOML text of a number (the shortest text that is read back as the same number) or of a quoted
  /// string.
  static std::string toml_value(double value);
  static std::string toml_value(const std::string& text);
  /// TOML text of a point or direction, "[x, y, z]", with numbers as above.
  static std::string toml_value(const Vec3& p);
  /// TOML text of a list of values given as TOML text, or of a list of strings.
  static std::string list(const std::vector<std::string>& values);
  static std::string toml_string_list(const std::vector<std::string>& texts);
  /// TOML text of an inline table, "{ key = value, … }", whose values are given as TOML text.
  static std::string inline_table(const std::vector<Value>& values);

 private:
  struct Span;
  struct Parsed;
  void read();
  bool set_of_handle(const std::string& handle, const std::string& number, double value);
  void set_rotation(const SceneTable& handle, const std::string& number, double value);
  void splice(size_t from, size_t to, const std::string& with);
  std::filesystem::path file_;
  std::string text_;
  std::vector<SceneTable> names_;
};

// Comparison of two versions of a scene: does an edit require a new model, a new session, or only
// new parameter values?

/// The parts of a scene on which its results depend, as text without comments and layout.
struct SceneDependencies {
  /// Text of curves, faces, [skin] and [mesh]. Scenes with equal text have the same model.
  std::string model;
  /// Text of the tables of curves and faces only, without [skin] and [mesh].
  std::string lines;
  /// Text of each load, stiffness field, offset, constraint and [[parameter]] without its value, by
  /// "KIND NAME". Scenes with equal `model` and `session_parts` differ only in the values of
  /// parameters.
  std::map<std::string, std::string> session_parts;
};

/// Extracts the parts of a scene on which results depend. The material stiffnesses alpha and beta
/// count as parameter values if they are single numbers. Cost: O(bytes).
SceneDependencies scene_dependencies(const SceneText& scene);

}  // namespace batten
