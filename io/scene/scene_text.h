// Edits the text of a scene file in place, preserving its layout and comments.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace batten {

/// Identifies one table of a scene. [skin] is {"skin", ""}; the [[load]] named "push" is {"load",
/// "push"}. Unnamed tables are identified by their position: {"join", "#2"} is the second [[join]].
/// {} is the top level of the file. A nested table such as [[edit.handle]] combines both names:
/// {"edit.handle", "edit 1.right"}.
struct SceneTable {
  std::string kind = {}, name = {};
  bool operator==(const SceneTable&) const = default;
};

/// The text of a scene, with edits that change only the affected characters. Comments, order,
/// blanks and line ends of everything else stay.
///
/// Values are given as TOML: `"text"`, `[0, 0, 1]`, `{ point = [1, 2, 3] }`. parse_scene() checks
/// whether a key is valid in its table. An edit that fails throws InputError ("FILE:LINE:COLUMN:
/// …") and leaves the text unchanged; reasons are a value that is not TOML, or an unknown table or
/// key. Inline tables, `load = [{ … }]`, can be edited too. Cost: O(bytes) per edit.
class SceneText {
 public:
  /// `file` is used in messages only. Throws InputError if the text is not TOML.
  explicit SceneText(std::string text, std::filesystem::path file = {});

  /// The current text.
  const std::string& text() const { return text_; }
  /// The tables in file order, including nested ones such as [[edit.handle]].
  const std::vector<SceneTable>& tables() const { return names_; }
  /// True if the table exists.
  bool has(const SceneTable& table) const;
  /// A key and its value, as in the text.
  using Value = std::pair<std::string, std::string>;
  /// The keys and values of a table, in file order.
  std::vector<Value> values(const SceneTable& table) const;
  /// The keys and values of all tables, top level first.
  std::vector<std::pair<SceneTable, std::vector<Value>>> all_values() const;
  /// A value as in the text; empty if the key does not exist.
  std::string value(const SceneTable& table, const std::string& key) const;

  /// The elements of a list of strings, or a single string; empty for other values.
  std::vector<std::string> words(const SceneTable& table, const std::string& key) const;

  /// Replaces the value of a key, or adds the key after the last one of its table. A missing table
  /// [KIND] is created first.
  void set(const SceneTable& table, const std::string& key, const std::string& value);
  /// Replaces one element of a list; `item` is 0-based.
  void set_item(const SceneTable& table, const std::string& key, int item,
                const std::string& value);
  /// Removes a key and its value.
  void erase(const SceneTable& table, const std::string& key);
  /// Adds a table [[KIND]] after the last one of its kind, or at the end of the file. `table` is
  /// its text as an inline table: `{ name = "push", type = "point", … }`. An [[edit.handle]] is
  /// added to the last [[edit]]. The kind "[stress]", with brackets, creates the single table
  /// [stress]. The result identifies the new table.
  SceneTable add(const std::string& kind, const std::string& table);
  /// Removes a table and the comments directly above it.
  void remove(const SceneTable& table);
  /// Writes the value of a parameter (Scene::parameters()) at its location in the scene. A
  /// time-dependent value becomes constant.
  void set_parameter(const std::string& parameter, double value);

  /// TOML text of a number (the shortest that reads back exactly) and of a string (quoted).
  static std::string word(double value);
  static std::string word(const std::string& text);
  /// TOML text of a list of values, and of a list of strings.
  static std::string list(const std::vector<std::string>& values);
  static std::string toml_string_list(const std::vector<std::string>& texts);

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

// Parts of a scene's text that determine whether an edit requires a new model, a new session, or
// only new values.

/// The parts of a scene that determine its results, normalised without comments and layout.
struct SceneDependencies {
  /// Curves, faces, [skin] and [mesh]: texts with equal `model` have the same model.
  std::string model;
  /// Like `model`, but without [skin] and [mesh].
  std::string lines;
  /// Each load, stiffness field, offset, constraint and [[parameter]], by "KIND NAME" and without its value.
  /// Texts with equal `session_parts` differ at most in the values of parameters.
  std::map<std::string, std::string> session_parts;
};

/// Extracts these parts. alpha and beta count as values if they are numbers. Cost: O(bytes).
SceneDependencies scene_dependencies(const SceneText& scene);

}  // namespace batten
