// SPDX-License-Identifier: MPL-2.0
// Atomic output files: a file is either written completely or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>

#include "batten/core/errors.h"

namespace batten {

// Registry of temporary files and folders, for programs that must terminate before the files are
// finished.

/// Registers a temporary file or folder for removal: remove_temporary_files() removes the paths of
/// all existing guards. A guard may be created in any thread, and before its path exists.
class TemporaryFileGuard {
 public:
  enum class Content {
    Remove,  ///< removes a file, or a folder with its contents
    Keep     ///< removes a folder only if it is empty
  };
  explicit TemporaryFileGuard(std::filesystem::path path, Content content = Content::Remove);
  ~TemporaryFileGuard();
  TemporaryFileGuard(const TemporaryFileGuard&) = delete;
  TemporaryFileGuard& operator=(const TemporaryFileGuard&) = delete;

 private:
  friend void remove_temporary_files();
  void discard() const;

  std::filesystem::path path_;
  Content content_;
};

/// Makes finished files visible: calls `move`, which must rename them to their final names. While
/// `move` runs, remove_temporary_files() waits.
void commit_files(const std::function<void()>& move);

/// Removes all temporary files and folders that have a TemporaryFileGuard, most recent first.
/// Afterwards the program must terminate without running destructors (std::_Exit). Other threads
/// may still write but cannot finish any file, because commit_files() blocks from now on.
void remove_temporary_files();

/// Thrown if the operating system does not permit a file to be written, for example because the
/// disk is full or permission is missing. Later files will usually fail for the same reason.
class FileError : public InputError {
 public:
  using InputError::InputError;
};

/// An output file in progress. A library writes to temporary(), a file in the same folder with the
/// same extension. commit() renames the temporary file to its final name and thereby replaces an
/// existing file. Without commit(), the destructor removes the temporary file, and an existing file
/// stays unchanged.
class AtomicFile {
 public:
  /// Creates a temporary file in the folder of `path`, so that a missing or read-only folder is
  /// detected before a long computation. Removes temporary files of `path` that terminated
  /// processes left behind. Throws FileError, with the file name and the reason given by the
  /// system; also if `path` exists and is not a regular file.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Renames the temporary file to its final name. Call it once, after the temporary file has been
  /// closed. Throws FileError if the system refuses.
  void commit();

 private:
  std::filesystem::path path_, temporary_;
  std::optional<TemporaryFileGuard> guard_;
};

/// Writes a file atomically; `write` writes the content to the given stream (C locale, line ends
/// '\n'). Throws FileError if the file cannot be written, for example because the disk is full, and
/// all exceptions of `write`.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write);

/// Creates a folder and its parents if necessary, and verifies that files can be created in it.
/// Throws FileError if the folder cannot be created or used.
void make_output_folder(const std::filesystem::path& path);

}  // namespace batten
