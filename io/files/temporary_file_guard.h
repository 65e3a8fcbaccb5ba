// Files and folders that are being written, for a program that has to end before they are finished.
#pragma once

#include <filesystem>
#include <functional>

namespace batten {

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

}  // namespace batten
