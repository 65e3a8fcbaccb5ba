// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/scene_paths.h"

#include <algorithm>

namespace batten {
namespace {

/// Tables of a scene whose key `file` is a path.
constexpr const char* kFileTables[] = {"curve",     "curves",  "load",   "target",
                                       "neighbour", "compare", "select", "field"};

/// True if a relative path goes up so many levels that an absolute one is more readable.
bool is_outside(const std::filesystem::path& relative) {
  constexpr auto most = 2;
  return std::count(relative.begin(), relative.end(), std::filesystem::path("..")) > most;
}

}  // namespace

SceneText with_paths(SceneText text, const PathChange& change) {
  const auto move = [&](const SceneTable& table, const std::string& key) {
    const std::string value = text.value(table, key);
    if (value.size() < 2 || (value.front() != '"' && value.front() != '\'')) return;
    const std::string changed = change(value.substr(1, value.size() - 2));
    if (!changed.empty()) text.set(table, key, SceneText::toml_value(changed));
  };
  const std::vector<SceneTable> tables = text.tables();
  move({}, "mesh");
  if (text.has({"sequence", ""})) move({"sequence", ""}, "file");
  for (const SceneTable& table : tables)
    for (const char* kind : kFileTables)
      if (table.kind == kind) move(table, "file");
  return text;
}

SceneText with_moved_paths(SceneText text, const std::filesystem::path& from,
                           const std::filesystem::path& to, bool for_people) {
  return with_paths(std::move(text), [&](const std::filesystem::path& file) -> std::string {
    if (file.is_absolute()) return {};
    const std::filesystem::path full = (from / file).lexically_normal();
    const std::filesystem::path relative = full.lexically_relative(to);
    return (for_people && is_outside(relative) ? full : relative).string();
  });
}

SceneText relative_to_folder(SceneText text, const std::filesystem::path& folder) {
  return with_paths(std::move(text), [&](const std::filesystem::path& file) -> std::string {
    const std::filesystem::path relative = file.lexically_relative(folder);
    const bool below = file.is_absolute() && !relative.empty() && *relative.begin() != "..";
    return below ? relative.string() : std::string();
  });
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).parent_path().lexically_normal();
}

}  // namespace batten
