// What a shape is written to.
#include "batten/apps/commands/documents/edited_shape.h"
#include "batten/apps/commands/shapes/export_shape.h"
#include "batten/apps/commands/shapes/run_scene.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

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
  const MadeShape shape = shape_of(*session_, scene_, start_.unloaded, answer_);
  return told(batten::export_shape(scene_, model_->model.made, shape, file, progress).missed);
}

}  // namespace batten
