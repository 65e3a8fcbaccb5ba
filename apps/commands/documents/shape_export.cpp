// What a shape is written to.
#include "batten/apps/commands/documents/edited_shape.h"
#include "batten/apps/commands/shapes/export_shape.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

std::string failed_check_text(const std::vector<FailedCheck>& failed_checks) {
  std::string text;
  for (const FailedCheck& one : failed_checks) text += one.what + ": " + one.detail + "\n";
  return text;
}

}  // namespace

std::string EditedShape::run(const std::filesystem::path& folder, const Progress& progress) {
  return failed_check_text(run_scene(scene_, folder, progress).failed_checks);
}

std::string EditedShape::export_shape(const std::filesystem::path& file, const Progress& progress) {
  if (!session_) throw InputError("found no surface, expected one to export");
  const SolvedShape shape = shape_of(*session_, scene_, start_.unloaded, solve_report_);
  return failed_check_text(
      batten::export_shape(scene_, model_->model.made, shape, file, progress).failed_checks);
}

}  // namespace batten
