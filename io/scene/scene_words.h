// What readers of scenes share. Internal.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"

namespace batten {

/// Names of one kind, each once.
class Names {
 public:
  explicit Names(std::string kind) : kind_(std::move(kind)) {}
  void add(const TomlTable& table, const std::string& key, const std::string& name) {
    const auto [it, added] = lines_.emplace(name, table.place(key).line);
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

/// Keys of [skin] and [output].
const std::vector<std::string>& skin_keys();
const std::vector<std::string>& output_keys();

/// A length unit. Throws InputError with the nearest one.
std::string unit_word(const TomlTable& table, const std::string& key);

/// A file of the output folder: a name without folders that ends in one of `endings` and is not in
/// `files` yet.
std::string output_file(const TomlTable& table, const std::string& key, Names& files,
                        const std::vector<std::string>& endings);

/// Keys view = [azimuth, elevation] and size = [width, height] of a picture; without them nothing
/// changes.
void read_view(const TomlTable& table, double& azimuth, double& elevation, PictureSize& size);

/// "from 0 to 10", "from 0 up", "up to 10".
std::string range_text(double min, double max);

/// `expected`: "a scene (.toml)". Throws InputError.
std::string text_of_file(const std::filesystem::path& file, const std::string& expected);
toml::table parse_toml(const std::string& text, const std::filesystem::path& file,
                       const std::string& expected);

}  // namespace batten
