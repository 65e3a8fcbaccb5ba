#include "batten/apps/commands/runs/output_folder.h"

#include <unistd.h>

#include "batten/core/errors.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  for (fs::path p = fs::absolute(folder_); !p.empty() && !fs::exists(p, error) && !error;
       p = p.parent_path())
    if (p.has_filename()) made_.insert(made_.begin(), p);
  make_output_folder(folder_);
  hidden_ = folder_ / (".batten-" + std::to_string(getpid()));
  fs::remove_all(hidden_, error);
  fs::create_directory(hidden_, error);
  if (error) throw InputError(hidden_.string() + ": cannot make this folder: " + error.message());
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(hidden_, ignored);
  if (!committed_)
    for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);  // if empty
}

void OutputFolder::commit() {
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(hidden_))
    names.push_back(entry.path().filename());
  for (const auto& name : names)
    if (fs::is_directory(folder_ / name))
      throw InputError((folder_ / name).string() +
                       ": cannot write this file: a folder has this name");
  for (const auto& name : names) {
    std::error_code error;
    fs::rename(hidden_ / name, folder_ / name, error);
    if (error)
      throw InputError((folder_ / name).string() + ": cannot write this file: " + error.message());
  }
  committed_ = true;
}

}  // namespace batten
