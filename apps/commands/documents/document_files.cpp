// What a document writes.
#include <algorithm>
#include <fstream>
#include <functional>

#include "batten/apps/commands/documents/document.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

/// Begins the first line of a recovery file.
constexpr const char* kChangesOf = "# batten-studio: changes of ";

/// Files that a scene names, by the tables that name them.
constexpr const char* kFileTables[] = {"line", "lines", "load", "target", "compare", "select"};

/// What a path of a scene is changed by: its words without quotes; nothing: it stays.
using PathChange = std::function<std::string(const std::filesystem::path& file)>;

/// The scene with the paths that it names changed.
SceneText with_paths(SceneText text, const PathChange& change) {
  const auto move = [&](const SceneTable& table, const std::string& key) {
    const std::string value = text.value(table, key);
    if (value.size() < 2) return;
    const std::string changed = change(value.substr(1, value.size() - 2));
    if (!changed.empty()) text.set(table, key, SceneText::word(changed));
  };
  const std::vector<SceneTable> tables = text.tables();
  move({}, "mesh");
  if (text.has({"sequence", ""})) move({"sequence", ""}, "file");
  for (const SceneTable& table : tables)
    for (const char* kind : kFileTables)
      if (table.kind == kind) move(table, "file");
  return text;
}

/// Whether a path goes up so far that nobody would write it.
bool is_outside(const std::filesystem::path& relative) {
  constexpr auto most = 2;
  return std::count(relative.begin(), relative.end(), std::filesystem::path("..")) > most;
}

/// The scene with its paths, which are relative to `from`, relative to `to`; absolute where they would go
/// far up and a person may read them.
SceneText with_moved_paths(SceneText text, const std::filesystem::path& from,
                           const std::filesystem::path& to, bool for_people = true) {
  return with_paths(std::move(text), [&](const std::filesystem::path& file) -> std::string {
    if (file.is_absolute()) return {};
    const std::filesystem::path full = (from / file).lexically_normal();
    const std::filesystem::path relative = full.lexically_relative(to);
    return (for_people && is_outside(relative) ? full : relative).string();
  });
}

/// The scene with paths of files in its folder, or below, as a person writes them.
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

}  // namespace

void Document::save(const std::filesystem::path& to) {
  if (!changed_sliders_.empty()) solve_to_equilibrium();
  const std::filesystem::path& file = to.empty() ? file_ : to;
  if (file.empty()) throw InputError("found no file to save to, expected its name");
  SceneText text = text_;
  if (!file_.empty() && folder_of(file) != folder_of(file_))
    text = with_moved_paths(std::move(text), folder_of(file_), folder_of(file));
  if (file_.empty()) text = relative_to_folder(std::move(text), folder_of(file));
  write_file_atomically(file, [&](std::ostream& out) { out << text.text(); });
  file_ = file;
  text_ = std::move(text);
  saved_ = text_.text();
  content_->update_text(text_, file_);
}

// What the scene reads is not written over: opened again, the scene would change the result once more.
void Document::require_inputs_preserved(const std::filesystem::path& written) const {
  std::error_code none;
  const std::filesystem::path folder = file_.empty() ? "" : folder_of(file_);
  with_paths(text_, [&](const std::filesystem::path& file) -> std::string {
    if (std::filesystem::equivalent(folder / file, written, none))
      throw InputError("found " + written.string() +
                       ", which this scene reads, expected another file to write");
    return {};
  });
}

std::string Document::recovery_text(const std::filesystem::path& folder) const {
  const bool named = !file_.empty();
  SceneText text = text_with_values();
  // Paths come back as they were only if they stay relative.
  if (named)
    text =
        with_moved_paths(std::move(text), folder_of(file_), folder_of(folder / "changes"), false);
  return kChangesOf + (named ? std::filesystem::absolute(file_).string() : "") + "\n" + text.text();
}

void Document::recover(const std::filesystem::path& from, const Progress& progress) {
  const std::string bytes = read_input_file(from, "changes of a scene");
  const size_t end = bytes.find('\n');
  if (!bytes.starts_with(kChangesOf) || end == std::string::npos)
    throw InputError(from.string() + ": found no line '" + kChangesOf + "…', expected it first");
  const size_t begin = std::string(kChangesOf).size();
  const std::filesystem::path file = bytes.substr(begin, end - begin);
  SceneText text(bytes.substr(end + 1), from);
  if (!file.empty()) text = with_moved_paths(std::move(text), folder_of(from), folder_of(file));
  start(std::move(text), file, progress);
  std::error_code none;
  saved_ =
      !file.empty() && std::filesystem::exists(file, none) ? read_input_file(file, "a scene") : "";
}

}  // namespace batten
