// SPDX-License-Identifier: MPL-2.0
// Temporary folders for files in progress: unique names, locks, and removal when a program ends
// early.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace batten {

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

/// Removes all temporary files and folders that have a TemporaryFileGuard, most recent first.
/// Afterwards the program must terminate without running destructors (std::_Exit). Other threads
/// may still write but cannot finish any file, because CommitLock blocks from now on.
void remove_temporary_files();

/// While an object exists, remove_temporary_files() waits: finished files get their final names.
class CommitLock {
 public:
  CommitLock();
  ~CommitLock();
  CommitLock(const CommitLock&) = delete;
  CommitLock& operator=(const CommitLock&) = delete;
};

/// A temporary folder that this process has created and locked, for files in progress.
///
/// The name is ".STEM.SYSTEM-RANDOM": SYSTEM identifies the running operating system (Linux's
/// boot_id), and RANDOM is a random number of 64 bits. Therefore, processes with the same process
/// id, in containers or on machines that share a disk, never use the same folder.
///
/// A lock (flock) on the file `.lock` in the folder shows to other processes that the folder is in
/// use, even if this process is stopped.
class TemporaryFolder {
 public:
  /// Creates the folder in the folder `parent`, and removes leftovers of the same stem: those of
  /// processes of this system that no longer run, and those of other systems that have not changed
  /// for a week. Throws std::system_error.
  TemporaryFolder(const std::filesystem::path& parent, const std::string& stem);
  /// Removes the folder with its contents, and unlocks it.
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path lock_file() const;
  /// The files and empty folders that remain to be removed when all files in progress have been
  /// moved, in this order.
  std::vector<std::filesystem::path> remains() const;

 private:
  std::filesystem::path path_;
  int lock_ = -1;
  std::optional<TemporaryFileGuard> guard_;
};

/// True if a component of the path has the form of the names of TemporaryFolder.
bool is_temporary(const std::filesystem::path& path);

/// The stem of the innermost temporary folder of a path; empty: none.
std::string temporary_stem(const std::filesystem::path& path);

/// The path without the components that are names of temporary folders: the path for messages.
std::filesystem::path without_temporary_folders(const std::filesystem::path& path);

/// Locks a folder for the time in which files get their final names: waits until no other process
/// holds the lock, on this or another machine. The lock is the file `.batten-lock` in the folder,
/// which the destructor removes.
class FolderLock {
 public:
  /// Throws std::system_error if the file system has no locks or the folder is not writable.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  const std::filesystem::path& file() const { return file_; }

 private:
  std::filesystem::path file_;
  int lock_ = -1;
};

}  // namespace batten
