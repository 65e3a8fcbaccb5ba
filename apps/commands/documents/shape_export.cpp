// What a shape is written to.
#include <cstdlib>

#include "batten/apps/commands/documents/edited_shape.h"
#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace {

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

std::string told(const std::vector<MissedPromise>& missed) {
  std::string text;
  for (const MissedPromise& one : missed) text += one.what + ": " + one.detail + "\n";
  return text;
}

}  // namespace

std::string EditedShape::run(const std::filesystem::path& folder, const Progress& progress) {
  return told(run_scene(scene_, folder, progress).missed);
}

std::string EditedShape::export_shape(const std::filesystem::path& file, const Progress& progress) {
  if (!session_) throw InputError("found no surface, expected one to export");
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
  std::string missed = told(run.report.missed);
  const std::filesystem::path written = folder.path() / (facets ? scene.vtp : scene.step);
  if (facets || step) {
    copy_whole(written, file);
    return missed;
  }
  ConvertTask task;
  task.from = written;
  task.to = file;
  return missed + told(run_convert(task, progress).missed);
}

}  // namespace batten
