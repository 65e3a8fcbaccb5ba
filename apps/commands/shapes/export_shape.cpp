#include "batten/apps/commands/shapes/export_shape.h"

#include <cstdlib>

#include "batten/apps/commands/exchange/run_convert.h"
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

/// The scene with one output only, and the name of that.
std::string ask_for_one_output(Scene& scene, const std::string& ending) {
  scene.step = scene.vtp = scene.vtu = scene.calculix = "";
  scene.compare.clear();
  if (ending.empty()) return "";
  std::string& output = ending == ".vtp"   ? scene.vtp
                        : ending == ".vtu" ? scene.vtu
                        : ending == ".inp" ? scene.calculix
                                           : scene.step;
  output = &output == &scene.step ? "shape.step" : "shape" + ending;
  return output;
}

}  // namespace

Report export_shape(const Scene& of, const MadeModel& made_before, const MadeShape& shape,
                    const std::filesystem::path& file, const Progress& progress) {
  const PrivateFolder folder;
  const std::string ending = lower_extension(file);
  Scene scene = of;
  const std::string output = ask_for_one_output(scene, ending);
  if (!scene.calculix.empty() && !scene.stress)
    throw InputError(
        file.string() +
        ": found no [stress] in the scene, expected the thickness and material of a deck");
  ShapeRun run(scene, folder.path());
  run.report.parameters = scene.parameters();
  MadeModel made = made_before;
  run.tolerance = made.fit_tolerance;
  measure_into(run, made, shape, scene, progress);
  write_files(run, scene, made, shape, progress);
  write_step_file(run, scene, made, progress);
  run.finish(progress);
  run.out.commit();
  if (output.empty()) return std::move(run.report);
  const std::filesystem::path written = folder.path() / output;
  if (ending == lower_extension(written) || ending == ".stp") {
    copy_whole(written, file);
    return std::move(run.report);
  }
  ConvertTask task;
  task.from = written;
  task.to = file;
  const ConvertReport converted = run_convert(task, progress);
  run.report.missed.insert(run.report.missed.end(), converted.missed.begin(),
                           converted.missed.end());
  return std::move(run.report);
}

}  // namespace batten
