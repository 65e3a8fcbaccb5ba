// The files of one run: all of them appear, or none.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// Files are written into a hidden folder inside the output folder and moved to their names by
/// commit(). Without it they are removed, files of earlier runs stay as they were, and folders that
/// did not exist before are gone again.
class OutputFolder {
 public:
  /// Makes the folder and those above it. Throws InputError when it cannot be written to.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write the file of this name until commit().
  std::filesystem::path file(const std::string& name) const { return hidden_ / name; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Call once. Throws InputError, before anything is moved, when a name is taken by a folder.
  void commit();

 private:
  std::filesystem::path folder_, hidden_;
  std::vector<std::filesystem::path> made_;  // outermost first
  bool committed_ = false;
};

}  // namespace batten
