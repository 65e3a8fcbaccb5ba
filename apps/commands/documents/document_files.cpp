// What a document writes.
#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "batten/apps/commands/documents/document.h"
#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace {

/// Begins the first line of a recovery file.
constexpr const char* kChangesOf = "# batten-studio: changes of ";

/// Files that a scene names, by the tables that name them.
constexpr const char* kFileTables[] = {"line", "lines", "load", "target", "compare"};

/// Whether a path goes up so far that nobody would write it.
bool far(const std::filesystem::path& relative) {
  constexpr auto most = 2;
  return std::count(relative.begin(), relative.end(), std::filesystem::path("..")) > most;
}

/// The scene with its paths, which are relative to `from`, relative to `to`.
SceneText moved(SceneText text, const std::filesystem::path& from,
                const std::filesystem::path& to) {
  const std::vector<SceneTable> tables = text.tables();
  for (const SceneTable& table : tables)
    for (const char* kind : kFileTables) {
      const std::string value = table.kind == kind ? text.value(table, "file") : "";
      if (value.size() < 2) continue;
      const std::filesystem::path file = value.substr(1, value.size() - 2);
      if (file.is_absolute()) continue;
      const std::filesystem::path full = (from / file).lexically_normal();
      const std::filesystem::path relative = full.lexically_relative(to);
      text.set(table, "file", SceneText::word((far(relative) ? full : relative).string()));
    }
  return text;
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).parent_path().lexically_normal();
}

/// A folder for a while.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "batten_export_XXXXXX").string();
    if (!mkdtemp(name.data())) throw FileError(name + ": cannot be made");
    path_ = name;
  }
  ~PrivateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  WholeFile file(to);
  std::filesystem::copy_file(from, file.temporary(),
                             std::filesystem::copy_options::overwrite_existing);
  file.commit();
}

}  // namespace

void Document::save(const std::filesystem::path& to) {
  if (!slid_.empty()) settle();
  const std::filesystem::path& file = to.empty() ? file_ : to;
  if (file.empty()) throw InputError("found no file to save to, expected its name");
  SceneText text = text_;
  if (!file_.empty() && folder_of(file) != folder_of(file_))
    text = moved(std::move(text), folder_of(file_), folder_of(file));
  write_whole_file(file, [&](std::ostream& out) { out << text.text(); });
  file_ = file;
  text_ = std::move(text);
  saved_ = text_.text();
  scene_.file = file_;
}

std::string Document::recovery_text(const std::filesystem::path& folder) const {
  const bool named = !file_.empty();
  const SceneText text = named ? moved(text_, folder_of(file_), folder) : text_;
  return kChangesOf + (named ? std::filesystem::absolute(file_).string() : "") + "\n" + text.text();
}

void Document::recover(const std::filesystem::path& from, const Progress& progress) {
  const std::string bytes = input_bytes(from, "changes of a scene");
  const size_t end = bytes.find('\n');
  if (!bytes.starts_with(kChangesOf) || end == std::string::npos)
    throw InputError(from.string() + ": found no line '" + kChangesOf + "…', expected it first");
  const size_t begin = std::string(kChangesOf).size();
  const std::filesystem::path file = bytes.substr(begin, end - begin);
  SceneText text(bytes.substr(end + 1), from);
  if (!file.empty()) text = moved(std::move(text), folder_of(from), folder_of(file));
  start(std::move(text), file, progress);
  std::error_code none;
  saved_ = !file.empty() && std::filesystem::exists(file, none) ? input_bytes(file, "a scene") : "";
}

void Document::export_shape(const std::filesystem::path& file, const Progress& progress) {
  if (!session_) throw InputError("found no surface, expected one to export");
  if (!slid_.empty()) settle();
  const PrivateFolder folder;
  const std::string ending = lower_extension(file);
  const bool facets = ending == ".vtp", step = ending == ".step" || ending == ".stp";
  Scene scene = scene_;
  scene.step = facets ? "" : "shape.step";
  scene.vtp = facets ? "shape.vtp" : "";
  scene.vtu = scene.calculix = "";
  scene.compare.clear();
  ShapeRun run(scene, folder.path());
  MadeModel made = model_->model.made;
  run.tolerance = made.fit_tolerance;
  MadeShape shape = shape_of(*session_, scene, start_.unloaded, answer_);
  measure_into(run, made, shape, scene, progress);
  write_files(run, scene, made, shape, progress);
  write_step_file(run, scene, made, progress);
  run.finish(progress);
  run.out.commit();
  for (const MissedPromise& missed : run.report.missed)
    told_ += missed.what + ": " + missed.detail + "\n";
  const std::filesystem::path written = folder.path() / (facets ? scene.vtp : scene.step);
  if (facets || step) return copy_whole(written, file);
  ConvertTask task;
  task.from = written;
  task.to = file;
  const ConvertReport converted = run_convert(task, progress);
  for (const MissedPromise& missed : converted.missed)
    told_ += missed.what + ": " + missed.detail + "\n";
}

}  // namespace batten
