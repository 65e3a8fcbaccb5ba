// The output folder of a run: all its files appear, or none.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// Files are written into a hidden folder inside the output folder, and commit() moves them to
/// their names. Without a commit the destructor removes them and the folders that the constructor
/// made; files of earlier runs stay as they were.
class OutputFolder {
 public:
  /// Makes the folder and those above it. Throws InputError when it cannot be written to.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The path at which to write the file of this name before commit().
  std::filesystem::path file(const std::string& name) const { return hidden_ / name; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Moves all files to their names. Call it once. Throws InputError, before anything is moved,
  /// when a folder has the name of a file.
  void commit();

 private:
  std::filesystem::path folder_, hidden_;
  std::vector<std::filesystem::path> made_;  // folders that were made, outermost first
  bool committed_ = false;
};

}  // namespace batten
