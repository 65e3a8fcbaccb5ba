#include "batten/apps/commands/shapes/export_shape.h"

#include <cstdlib>

#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

/// A folder for a while.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "batten_export_XXXXXX").string();
    if (!mkdtemp(name.data())) throw FileError(name + ": cannot be made");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void copy_whole(const std::filesystem::path& from, const std::filesystem::path& to) {
  AtomicFile file(to);
  std::filesystem::copy_file(from, file.temporary(),
                             std::filesystem::copy_options::overwrite_existing);
  file.commit();
}

/// The scene with one output only, and the name of that.
std::string require_single_output(Scene& scene, const std::string& ending) {
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

Report export_shape(const Scene& of, const BuiltModel& made_before, const SolvedShape& shape,
                    const std::filesystem::path& file, const Progress& progress) {
  const TemporaryFolder folder;
  const std::string ending = lower_extension(file);
  Scene scene = of;
  const std::string output = require_single_output(scene, ending);
  if (!scene.calculix.empty() && !scene.stress)
    throw InputError(
        file.string() +
        ": found no [stress] in the scene, expected the thickness and material of a deck");
  RunContext run(scene, folder.path());
  run.report.parameters = scene.parameters();
  BuiltModel made = made_before;
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
  run.report.failed_checks.insert(run.report.failed_checks.end(), converted.failed_checks.begin(),
                                  converted.failed_checks.end());
  return std::move(run.report);
}

}  // namespace batten
