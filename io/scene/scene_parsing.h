// SPDX-License-Identifier: MPL-2.0
// Functions shared by all scene readers.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/scene/scene_selections.h"

namespace batten {

struct SceneLine;

/// Checks that names are unique within one kind of object in a scene. `kind` is its name in
/// messages.
class UniqueNames {
 public:
  explicit UniqueNames(std::string kind) : kind_(std::move(kind)) {}
  /// Adds the name given by `key` of the table. Throws InputError for a duplicate.
  void add(const TomlTable& table, const std::string& key, const std::string& name) {
    const auto [it, added] = lines_.emplace(name, table.location(key).line);
    if (!added)
      table.fail(key,
                 "the " + kind_ + " '" + name + "' again (first in line " +
                     std::to_string(it->second) + ")",
                 "a " + kind_ + " of its own");
  }
  /// True if the name was added before.
  bool has(const std::string& name) const { return lines_.count(name) > 0; }
  /// Reads all tables of a kind into a list, and checks that their names are unique.
  template <class Thing, class Read>
  void read(const TomlTable& root, const std::string& key, std::vector<std::string> keys,
            std::vector<Thing>& list, const Read& read_one) {
    for (const TomlTable& t : root.tables(key, std::move(keys))) {
      list.push_back(read_one(t));
      add(t, "name", list.back().name);
    }
  }

 private:
  std::string kind_;
  std::map<std::string, int> lines_;
};

/// Formats a part of a scene on one line of TOML: tables as inline tables, numbers with the fewest
/// digits that read back exactly. Equal values give equal text.
std::string to_toml(const toml::node& part);

/// Permitted keys of [skin], [mesh] and [output].
const std::vector<std::string>& skin_keys();
const std::vector<std::string>& mesh_keys();
const std::vector<std::string>& output_keys();

/// Reads a length unit. Throws InputError, with the nearest unit as a suggestion, for an unknown
/// one.
std::string read_unit(const TomlTable& table, const std::string& key);

/// Reads the name of an output file and adds it to `files`. Throws InputError for a name with
/// folders, an extension that is not in `endings`, or a name that is already in `files`.
std::string output_file(const TomlTable& table, const std::string& key, UniqueNames& files,
                        const std::vector<std::string>& endings);

/// Reads view = [azimuth, elevation] (degrees) and size = [width, height] (pixels) of a picture.
/// Arguments without a key keep their values. Throws InputError.
void read_view(const TomlTable& table, double& azimuth, double& elevation, PictureSize& size);

/// A range as text: "from 0 to 10", "from 0 up", "up to 10". At least one end is finite.
std::string format_range(double min, double max);

/// Parses TOML text; `file` appears in messages, `expected` says what the text should be. Throws
/// InputError if the text is empty, is not TOML, or is nested too deeply (check_nesting_depth).
toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       const std::string& expected);

// Reading of selections and features.

/// Reads a string with its location in the file.
LocatedString read_string(const TomlTable& table, const std::string& key);
/// Converts a number to a node label. Throws InputError if it is not an integer.
long read_label(const TomlTable& table, const std::string& key, double value);
/// Reads a list of node labels. Throws InputError like read_label().
std::vector<long> read_labels(const TomlTable& table, const std::string& key);

/// Reads [proposals]: options of the automatic feature detection.
void read_proposals(const TomlTable& root, FeatureDetectionOptions& options);
/// Reads [[select]] and [[cut]], which share one namespace. Files are relative to `folder`.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene);
/// Reads [[feature]] (a single feature) and [[features]] (several of one kind). `taken`: names
/// already in use.
std::vector<FeatureSpec> read_features(const TomlTable& root, UniqueNames& taken);

// Keys of older versions of Batten, and names that other programs use for the same things.

/// Kinds of scenes, which have different keys.
enum class SceneKind { Surface, Deform, Sequence };

/// Throws InputError "FILE:LINE:COLUMN: found the key 'line' …, expected 'curve'" at the first key
/// or value of `root`, in the order of the file, that has another name now. Other unknown keys are
/// left to TomlTable.
void refuse_renamed_keys(const toml::table& root, SceneKind kind, const std::string& file);

// Reading of [[curve]] and [[curves]].

/// Permitted keys of [[curve]] and [[curves]]; `roles` as in read_scene_lines().
std::vector<std::string> line_keys(bool roles);
std::vector<std::string> lines_keys(bool roles);

/// The keys that define the shape of a [[curve]], including files and points; each line has exactly
/// one.
const std::vector<std::string>& shape_keys();

/// Reads all lines of a scene. `roles`: true if lines of this kind of scene have a role (outline,
/// hole, inner) and a mesh alignment. `folder`: base of relative paths. Throws InputError, also if
/// there is no line although `required` is set.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required = true);

}  // namespace batten
