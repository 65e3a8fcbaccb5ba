// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/command_files.h"

#include <sys/stat.h>

#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/temporary_folder.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

using Identity = std::pair<dev_t, ino_t>;

struct Record {
  std::mutex mutex;
  int commands = 0, replaceable = 0;
  std::map<Identity, fs::path> inputs;
};

// Never destroyed: the program may terminate while a thread still uses it.
Record& record() {
  static auto* const all = new Record;
  return *all;
}

std::optional<Identity> identity(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  return Identity{found.st_dev, found.st_ino};
}

}  // namespace

CommandFiles::CommandFiles(Inputs inputs) : replaceable_(inputs == Inputs::Replaceable) {
  const std::lock_guard lock(record().mutex);
  ++record().commands;
  record().replaceable += replaceable_;
}

CommandFiles::~CommandFiles() {
  Record& all = record();
  const std::lock_guard lock(all.mutex);
  all.replaceable -= replaceable_;
  if (--all.commands == 0) all.inputs.clear();
}

void record_input(const fs::path& file) {
  if (is_temporary(file)) return;
  const auto found = identity(file);
  const std::lock_guard lock(record().mutex);
  if (found && record().commands > 0) record().inputs.emplace(*found, file);
}

void require_not_input(const fs::path& file, const fs::path& shown) {
  const auto found = identity(file);
  if (!found) return;
  Record& all = record();
  const std::lock_guard lock(all.mutex);
  if (all.replaceable > 0) return;
  const auto input = all.inputs.find(*found);
  if (input == all.inputs.end()) return;
  const std::string read = input->second.lexically_normal().string();
  throw InputError(
      shown.string() + ": found an input file of this command" +
      (read == shown.lexically_normal().string() ? "" : " (" + read + ")") +
      " as output file, expected another name (the option --in-place replaces the file)");
}

ReplaceableInput::ReplaceableInput(const fs::path& file) : file_(file) {
  const auto found = identity(file);
  const std::lock_guard lock(record().mutex);
  if (found) was_recorded_ = record().inputs.erase(*found) > 0;
}

ReplaceableInput::~ReplaceableInput() {
  if (was_recorded_) record_input(file_);  // the new file of this name
}

}  // namespace batten
