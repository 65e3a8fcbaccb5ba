// SPDX-License-Identifier: MPL-2.0
// Atomic output files: a file is either written completely or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/errors.h"
#include "batten/io/files/temporary_folder.h"

namespace batten {

/// Thrown if the operating system does not permit a file to be written, for example because the
/// disk is full or permission is missing. Later files will usually fail for the same reason.
class FileError : public InputError {
 public:
  using InputError::InputError;
};

/// The file that a name refers to, after symbolic links; it need not exist, but its folder must.
///
/// Throws FileError if a file of this name must not or cannot be replaced: a folder, a device, a
/// file without write permission for anybody, or a file with several hard links, one of which
/// would keep the old contents. Throws InputError for an input file of the current command
/// (CommandFiles).
std::filesystem::path replaceable_file(const std::filesystem::path& path);

/// Stem of the temporary folders that collect the files of a run, which flushes them together.
inline constexpr char kRunStem[] = "batten";

/// An output file in progress. A library writes to temporary(), a file of the same name in a
/// temporary folder beside the final file. commit() moves the temporary file to its final place and
/// thereby replaces an existing file, whose permissions it gets. Without commit(), the destructor
/// removes the temporary file, and an existing file stays unchanged.
class AtomicFile {
 public:
  /// Creates the temporary folder, so that a missing or read-only folder is detected before a long
  /// computation. Removes temporary folders of `path` that terminated processes left behind. Throws the exceptions of replaceable_file(), and FileError with the
  /// reason given by the system.
  explicit AtomicFile(std::filesystem::path path);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Writes the temporary file; `write` writes the contents to the given stream (C locale, line
  /// ends '\n'). Throws FileError if that fails, and the exceptions of `write`.
  void write(const std::function<void(std::ostream&)>& write);
  /// Flushes the temporary file to the disk and moves it to its final place. Call it once, after
  /// the temporary file has been closed. Throws FileError if the system refuses.
  void commit();
  const TemporaryFolder& folder() const { return *folder_; }

 private:
  std::filesystem::path path_, temporary_;
  std::optional<TemporaryFolder> folder_;
};

/// A file that gets its final name: `to` is replaced by `from`, which must be on the same file
/// system.
struct FileMove {
  std::filesystem::path from, to;
};

/// Renames finished files to their final names, all or none.
///
/// The files are written to the disk before. The last file is the one that tells that the others
/// are complete, such as a report: an existing file of its name is removed first, and it is renamed
/// last. A child process renames the files, so that they are renamed even if this process is killed
/// meanwhile. If the system refuses a name, the previous files are restored, and FileError is
/// thrown. `removed`: files and empty folders that the child process removes afterwards.
void move_together(const std::vector<FileMove>& moves,
                   const std::vector<std::filesystem::path>& removed = {});

/// Throws InputError if two of the files are the same.
void require_distinct(const std::vector<const AtomicFile*>& files);
/// Commits those of the files that have been written together, like move_together().
void commit_together(const std::vector<const AtomicFile*>& files);

/// While an object exists, AtomicFile::commit() in this thread does not flush each file to the disk,
/// which takes some milliseconds: for many files of which each is complete by itself, such as the
/// frames of a sequence.
class DeferredFlush {
 public:
  DeferredFlush();
  ~DeferredFlush();
  DeferredFlush(const DeferredFlush&) = delete;
  DeferredFlush& operator=(const DeferredFlush&) = delete;
  /// Flushes everything that was written on the disk of a folder. Throws FileError if that fails.
  static void flush(const std::filesystem::path& folder);
};

/// Writes a file atomically; `write` writes the contents to the given stream (C locale, line ends
/// '\n'). Throws FileError if the file cannot be written, for example because the disk is full, and
/// all exceptions of `write`.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write);

/// Creates a folder and its parents if necessary, and verifies that files can be created in it.
/// Throws FileError if the folder cannot be created or used.
void make_output_folder(const std::filesystem::path& path);

}  // namespace batten
