#include "batten/apps/commands/sequences/sequence_task.h"

namespace batten {

std::string SequenceTask::name_of(const std::filesystem::path& file) const {
  if (!frames) return file.string();
  std::filesystem::path name = file;
  name.replace_filename(file.stem().string() + "_" + std::to_string(frames->first) + "-" +
                        std::to_string(frames->second) + file.extension().string());
  return name.string();
}

}  // namespace batten
