// Files that include others.
#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/meshes/mesh_source_text.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

// Files that include others twice, which do the same, would be read without end.
constexpr size_t kMostFiles = 10000;
constexpr int kDeepestInclude = 64;

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path true_path(const fs::path& file) {
  std::error_code error;
  const fs::path result = fs::weakly_canonical(file, error);
  return error ? file.lexically_normal() : result;
}

/// From `folder` to a file in it or below; empty for one that lies elsewhere.
fs::path inside(const fs::path& file, const fs::path& folder) {
  const fs::path way = true_path(file).lexically_relative(true_path(folder));
  return way.empty() || *way.begin() == ".." || *way.begin() == "." ? fs::path() : way;
}

/// Decks from elsewhere have the separators of elsewhere.
std::string with_slashes(std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  return name;
}

}  // namespace

std::string MeshSourceText::include_trace(size_t offset) const {
  std::string text;
  for (size_t at = offset; at != std::string::npos; at = source_of(at).included_at) {
    const std::string line = line_name(at, at);
    text = source_of(at).path.string() + ":" + line.substr(line.find(' ') + 1) + ": " + text;
  }
  return text;
}

void MeshSourceText::include(const std::string& name, std::string_view where,
                             const std::vector<std::string>& folders) {
  const size_t line = offset(where);
  if (name.empty()) fail(line, "found no name of a file, expected one");
  const fs::path root = folder_of(path()), here = folder_of(source_of(line).path);
  fs::path found;
  bool elsewhere = false;
  for (const fs::path& named : {fs::path(name), fs::path(with_slashes(name))}) {
    std::vector<std::pair<fs::path, bool>> tries{{here / named, false}, {root / named, false}};
    for (const std::string& folder : folders)
      tries.push_back({root / folder / named, fs::path(folder).is_absolute()});
    for (const auto& [file, absolute] : tries) {
      std::error_code error;
      if (!found.empty() || !fs::exists(file, error)) continue;
      found = file;
      elsewhere = absolute || named.is_absolute();
    }
  }
  if (found.empty()) found = here / with_slashes(name);
  // Beside one another, names come out short: "parts/a.bdf" instead of "parts/../parts/a.bdf".
  found = found.lexically_normal();
  for (size_t at = line; at != std::string::npos; at = source_of(at).included_at)
    if (true_path(source_of(at).path) == true_path(found))
      throw InputError(include_trace(line) + "found " + found.string() +
                       ", which includes itself, expected files that end");
  if (depth() >= kDeepestInclude || sources_.size() >= kMostFiles)
    throw InputError(include_trace(line) + "found more files than are followed (" +
                     std::to_string(kMostFiles) + ", " + std::to_string(kDeepestInclude) +
                     " deep)");
  Source source{
      found, read_input_file(found, "an included file", include_trace(line)), 0, line, {}};
  if (position() + source.text.size() > kMaxInputFileSize)
    throw InputError(include_trace(line) + "found more text than is read");
  if (!elsewhere) source.beside = inside(found, root);
  open_.push_back({current_, at_});
  open(std::move(source), false);
}

}  // namespace batten
