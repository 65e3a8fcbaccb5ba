// Functions that all readers of scenes share. Internal.
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

/// The names of one kind of thing in a scene; `kind` is the word for it in messages.
class UniqueNames {
 public:
  explicit UniqueNames(std::string kind) : kind_(std::move(kind)) {}
  /// Adds the name that `key` of the table gives. Throws InputError when it was added before.
  void add(const TomlTable& table, const std::string& key, const std::string& name) {
    const auto [it, added] = lines_.emplace(name, table.location(key).line);
    if (!added)
      table.fail(key,
                 "the " + kind_ + " '" + name + "' again (first in line " +
                     std::to_string(it->second) + ")",
                 "a " + kind_ + " of its own");
  }
  bool has(const std::string& name) const { return lines_.count(name) > 0; }
  /// Reads all tables of a kind into a list, each under a name of its own.
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

/// A part of a scene in one line, as a person would write it: a table in braces, numbers with as few
/// digits as it takes. The same for the same values, to the last digit.
std::string to_toml(const toml::node& part);

/// Keys that [skin] and [output] may have.
const std::vector<std::string>& skin_keys();
const std::vector<std::string>& output_keys();

/// Reads a length unit. Throws InputError, with the nearest unit, for another word.
std::string read_unit(const TomlTable& table, const std::string& key);

/// Reads the name of an output file and adds it to `files`. Throws InputError: a name with folders,
/// an ending that is not in `endings`, a name that is in `files` already.
std::string output_file(const TomlTable& table, const std::string& key, UniqueNames& files,
                        const std::vector<std::string>& endings);

/// Reads the keys view = [azimuth, elevation] (degrees) and size = [width, height] (pixels) of a
/// picture. Values without a key keep what they were. Throws InputError.
void read_view(const TomlTable& table, double& azimuth, double& elevation, PictureSize& size);

/// A range in words: "from 0 to 10", "from 0 up", "up to 10". One of its ends is finite.
std::string format_range(double min, double max);

/// Parses a TOML text; messages name `file`. Throws InputError: an empty text, a text that is not
/// TOML, or nested too deeply (check_nesting_depth).
toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       const std::string& expected);


// Functions by which scenes read selections and features. Internal.

LocatedString read_string(const TomlTable& table, const std::string& key);
/// Whole numbers of nodes. Throws InputError for others.
long read_label(const TomlTable& table, const std::string& key, double value);
std::vector<long> read_labels(const TomlTable& table, const std::string& key);

/// [proposals]: what features are proposed.
void read_proposals(const TomlTable& root, FeatureDetectionOptions& options);
/// [[select]] and [[cut]], which share their names. Files are relative to `folder`.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene);
/// [[feature]] one by one, and [[features]], many of a kind. `taken`: names that are taken.
std::vector<FeatureSpec> read_features(const TomlTable& root, UniqueNames& taken);

}  // namespace batten
