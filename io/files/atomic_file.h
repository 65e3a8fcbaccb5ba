// Output files that are written whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>

#include "batten/core/errors.h"

namespace batten {

// Files and folders that are being written, for a program that has to end before they are finished.

/// While it lives, remove_temporary_files() removes a path. Instances may be made in any thread, and
/// before there is anything at the path.
class TemporaryFileGuard {
 public:
  enum class Content {
    Remove,  ///< a file, or a folder with all that is in it
    Keep     ///< a folder, if nothing is in it
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

/// Calls `move`, which gives finished files their names; remove_temporary_files() waits until it is done.
void commit_files(const std::function<void()>& move);

/// Removes what is unfinished, the last one first. The program has to end after that, without
/// destructors (std::_Exit): other threads may still write, but nothing is finished any more, since
/// commit_files() no longer returns.
void remove_temporary_files();


/// The system does not let a file be written: no room, no permission. What fails with this fails
/// for every file, not for one surface.
class FileError : public InputError {
 public:
  using InputError::InputError;
};

/// An output file that is being written. Libraries write to temporary(), a name in the same folder
/// with the same extension. commit() gives the file its real name in one step and replaces an older
/// one. Without a commit the destructor removes it, and an older file stays as it was.
class AtomicFile {
 public:
  /// Creates the temporary file, so that a folder that is missing or not writable is found out
  /// before the work is done. Removes those that killed programs left for a file of this name.
  /// Throws FileError with the file and the system's reason, also when `path` exists and is not a
  /// regular file.
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Gives the file its real name. Call it once, after the writer has closed the file. Throws
  /// FileError when the system refuses.
  void commit();

 private:
  std::filesystem::path path_, temporary_;
  std::optional<TemporaryFileGuard> guard_;
};

/// Writes a file, whole or not at all, with what `write` puts into the stream (numbers in the C
/// locale, '\n' line ends). Throws FileError, also when the disk is full, and whatever `write`
/// throws.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(std::ostream&)>& write);

/// Makes sure that the folder exists, with all folders above it, and that files can be created in
/// it. Throws FileError otherwise.
void make_output_folder(const std::filesystem::path& path);

}  // namespace batten
