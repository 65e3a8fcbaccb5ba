// The text of a scene file, changed as a person would change it.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>
#include <map>

namespace batten {

/// Names one table of a scene. [skin] is {"skin", ""}; of [[load]] the one named "push" is {"load",
/// "push"}; those without a name go by their number among their kind, {"join", "#2"} is the second.
/// {} is the top of the file. A table in a list of another one, [[edit.handle]], has the names of
/// both: {"edit.handle", "edit 1.right"}.
struct SceneTable {
  std::string kind = {}, name = {};
  bool operator==(const SceneTable&) const = default;
};

/// A scene's text, and edits that touch what they change and nothing else: comments, order, blanks
/// and line ends of all the rest stay.
///
/// Values are given as TOML writes them: `"text"`, `[0, 0, 1]`, `{ point = [1, 2, 3] }`. Whether a
/// key suits its table is for parse_scene() to say. Each edit either happens or throws InputError
/// ("FILE:LINE:COLUMN: …") and leaves the text as it was: a value that is not TOML, a table or key
/// that is not there. Tables in braces, `load = [{ … }]`, can be changed too. O(bytes) each.
class SceneText {
 public:
  /// `file` is named in messages only. Throws InputError for a text that is not TOML.
  explicit SceneText(std::string text, std::filesystem::path file = {});

  const std::string& text() const { return text_; }
  /// The tables in the order of the file, and those of lists inside of others, [[edit.handle]].
  const std::vector<SceneTable>& tables() const { return names_; }
  bool has(const SceneTable& table) const;
  /// A key and its value as it stands in the text.
  using Value = std::pair<std::string, std::string>;
  /// The keys of a table as the file has them.
  std::vector<Value> values(const SceneTable& table) const;
  /// Those of all tables, the top first.
  std::vector<std::pair<SceneTable, std::vector<Value>>> all_values() const;
  /// A value as it stands in the text; "" for a key that is not there.
  std::string value(const SceneTable& table, const std::string& key) const;

  /// The texts of a list of texts, or of one text alone; none for other values.
  std::vector<std::string> words(const SceneTable& table, const std::string& key) const;

  /// Replaces the value of a key, or adds the key behind the last of its table. A table of the form
  /// [KIND] that is missing is added first.
  void set(const SceneTable& table, const std::string& key, const std::string& value);
  /// Replaces one value of a list, counted from 0.
  void set_item(const SceneTable& table, const std::string& key, int item,
                const std::string& value);
  /// Removes a key with its value.
  void erase(const SceneTable& table, const std::string& key);
  /// Adds a table [[KIND]] behind the last of its kind, or at the end, from the text of a table in
  /// braces: `{ name = "push", type = "point", … }`; [[edit.handle]] belongs to the last [[edit]];
  /// "[stress]" as a kind makes the one table [stress].
  /// Returns the name it goes by.
  SceneTable add(const std::string& kind, const std::string& table);
  /// Removes a table and the comments right above it.
  void remove(const SceneTable& table);
  /// Writes the value of a parameter (Scene::parameters()) where the scene states it. A value over
  /// time becomes a constant.
  void set_parameter(const std::string& parameter, double value);

  /// A number as the shortest text that reads back as the same number, and a text in quotes.
  static std::string word(double value);
  static std::string word(const std::string& text);
  /// Values as a list, and texts as a list of texts.
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


// What in a scene's text decides what: whether an edit needs a new model, a new session, or values only.

/// The parts of a scene's text that decide what is made of it, without comments and layout.
struct SceneDependencies {
  /// Lines, network and skin: two texts with the same `model` have the same model.
  std::string model;
  /// The same without [skin].
  std::string lines;
  /// Each load, weight, move, constraint and [[parameter]] by "KIND NAME", without its value: two
  /// texts with the same `session_parts` differ in values of live parameters at most.
  std::map<std::string, std::string> session_parts;
};

/// The parts of a scene. alpha and beta are values where they are numbers. O(bytes).
SceneDependencies scene_dependencies(const SceneText& scene);

}  // namespace batten
