// SPDX-License-Identifier: MPL-2.0
// Protects the input files of a command: a file that is read is not overwritten.
#pragma once

#include <filesystem>

namespace batten {

/// While at least one object of this class exists, the files that this process reads are recorded,
/// and AtomicFile, commit_together() and OutputFolder refuse to replace them.
///
/// A file is identified by device and inode, so that symbolic links, hard links and different
/// spellings of a path make no difference. Front ends create one object per command; objects may be
/// nested and may exist in several threads at the same time, which then protect the files of all of
/// them. The record is discarded with the last object.
class CommandFiles {
 public:
  enum class Inputs {
    Protected,
    Replaceable  ///< the user allows that output files replace input files (`--in-place`)
  };
  explicit CommandFiles(Inputs inputs = Inputs::Protected);
  ~CommandFiles();
  CommandFiles(const CommandFiles&) = delete;
  CommandFiles& operator=(const CommandFiles&) = delete;

 private:
  bool replaceable_;
};

/// Records that the current command reads a file. Readers call it through require_input_file(),
/// read_input_file() and sandboxed_read(). Temporary files of this program are not recorded.
void record_input(const std::filesystem::path& file);

/// Throws InputError if the current command has read this file, so that it must not be replaced.
/// `shown`: name of the file for the message.
void require_not_input(const std::filesystem::path& file, const std::filesystem::path& shown);

/// Permits one file to be replaced while the object exists, although it was read: a document that is
/// saved under the name from which it was opened.
class ReplaceableInput {
 public:
  explicit ReplaceableInput(const std::filesystem::path& file);
  ~ReplaceableInput();
  ReplaceableInput(const ReplaceableInput&) = delete;
  ReplaceableInput& operator=(const ReplaceableInput&) = delete;

 private:
  std::filesystem::path file_;
  bool was_recorded_ = false;
};

}  // namespace batten
