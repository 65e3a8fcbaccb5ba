// Files and folders that are being written, for a program that has to end before they are finished.
#pragma once

#include <filesystem>
#include <functional>

namespace batten {

/// While it lives, discard_unfinished() removes a path. Instances may be made in any thread, and
/// before there is anything at the path.
class Unfinished {
 public:
  enum class Content {
    Remove,  ///< a file, or a folder with all that is in it
    Keep     ///< a folder, if nothing is in it
  };
  explicit Unfinished(std::filesystem::path path, Content content = Content::Remove);
  ~Unfinished();
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

 private:
  friend void discard_unfinished();
  void discard() const;

  std::filesystem::path path_;
  Content content_;
};

/// Calls `move`, which gives finished files their names; discard_unfinished() waits until it is done.
void finish_files(const std::function<void()>& move);

/// Removes what is unfinished, the last one first. The program has to end after that, without
/// destructors (std::_Exit): other threads may still write, but nothing is finished any more, since
/// finish_files() no longer returns.
void discard_unfinished();

}  // namespace batten
