#include "batten/io/files/temporary_file_guard.h"

#include <algorithm>
#include <mutex>
#include <system_error>
#include <vector>

namespace batten {
namespace fs = std::filesystem;
namespace {

struct Registry {
  std::mutex finishing, changing;
  std::vector<const TemporaryFileGuard*> list;
};

// It is never destroyed: the program may end while a thread still uses it.
Registry& registry() {
  static auto* const all = new Registry;
  return *all;
}

// The folder that the process is in may change, or be gone.
fs::path anchored(const fs::path& path) {
  std::error_code error;
  fs::path whole = fs::absolute(path, error);
  return error ? path : whole;
}

}  // namespace

TemporaryFileGuard::TemporaryFileGuard(fs::path path, Content content)
    : path_(anchored(path)), content_(content) {
  const std::lock_guard lock(registry().changing);
  registry().list.push_back(this);
}

TemporaryFileGuard::~TemporaryFileGuard() {
  Registry& all = registry();
  const std::lock_guard lock(all.changing);
  all.list.erase(std::find(all.list.begin(), all.list.end(), this));
}

void TemporaryFileGuard::discard() const {
  std::error_code error;
  if (content_ == Content::Keep) {
    fs::remove(path_, error);
    return;
  }
  // A thread that still writes may add a file while its folder is removed.
  constexpr int most_times = 20;
  for (int i = 0; i < most_times && fs::exists(fs::symlink_status(path_, error)); ++i)
    fs::remove_all(path_, error);
}

void commit_files(const std::function<void()>& move) {
  const std::lock_guard lock(registry().finishing);
  move();
}

void remove_temporary_files() {
  Registry& all = registry();
  all.finishing.lock();  // and never unlocked
  const std::lock_guard lock(all.changing);
  for (auto one = all.list.rbegin(); one != all.list.rend(); ++one) (*one)->discard();
}

}  // namespace batten
