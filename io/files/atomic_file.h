// Atomic output files: complete or not written at all.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>

#include "batten/core/errors.h"

namespace batten {

// Registry of temporary files and folders, for programs that must terminate before these are
// finished.

/// While a guard exists, remove_temporary_files() removes its path. Guards may be created in any
/// thread, and before the path exists.
class TemporaryFileGuard {
 public:
  enum class Content {
    Remove,  ///< a file, or a folder with its contents
    Keep     ///< a folder, only if it is empty
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

/// Calls `move`, which must rename finished files to their final names. remove_temporary_files()
/// waits until it returns.
void commit_files(const std::function<void()>& move);

/// Removes all unfinished files and folders, the last one first. The program must then terminate
/// without running destructors (std::_Exit). Other threads may still write, but they cannot finish
/// any file, because commit_files() no longer returns.
void remove_temporary_files();

/// Thrown if the system does not permit a file to be written: disk full, no permission. It is not
/// specific to one surface: later files will fail for the same reason.
class FileError : public InputError {
 public:
  using InputError::InputError;
};

/// An output file in progress. Libraries write to temporary(), a name in the same folder with the
/// same extension. commit() renames it to its final name in one step and replaces an existing file.
/// Without commit(), the destructor removes the temporary file, and an existing file is unchanged.
class AtomicFile {
 public:
  /// Creates the temporary file, so that a missing or read-only folder is detected before the work
  /// is done. Removes temporary files of `path` that killed processes left behind. Throws FileError
  /// with the file and the system's reason, also if `path` exists and is not a regular file.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Renames the file to its final name. Call it once, after the writer has closed the file. Throws
  /// FileError if the system refuses.
  void commit();

 private:
  std::filesystem::path path_, temporary_;
  std::optional<TemporaryFileGuard> guard_;
};

/// Writes a file atomically with what `write` puts into the stream (numbers in the C locale, '\n'
/// line ends). Throws FileError, also if the disk is full, and whatever `write` throws.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write);

/// Creates the folder with its parents if necessary, and verifies that files can be created in it.
/// Throws FileError otherwise.
void make_output_folder(const std::filesystem::path& path);

}  // namespace batten
