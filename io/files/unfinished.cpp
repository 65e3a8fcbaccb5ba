#include "batten/io/files/unfinished.h"

#include <algorithm>
#include <mutex>
#include <system_error>
#include <vector>

namespace batten {
namespace fs = std::filesystem;
namespace {

struct Registry {
  std::mutex finishing, changing;
  std::vector<const Unfinished*> list;
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

Unfinished::Unfinished(fs::path path, Content content) : path_(anchored(path)), content_(content) {
  const std::lock_guard lock(registry().changing);
  registry().list.push_back(this);
}

Unfinished::~Unfinished() {
  Registry& all = registry();
  const std::lock_guard lock(all.changing);
  all.list.erase(std::find(all.list.begin(), all.list.end(), this));
}

void Unfinished::discard() const {
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

void finish_files(const std::function<void()>& move) {
  const std::lock_guard lock(registry().finishing);
  move();
}

void discard_unfinished() {
  Registry& all = registry();
  all.finishing.lock();  // and never unlocked
  const std::lock_guard lock(all.changing);
  for (auto one = all.list.rbegin(); one != all.list.rend(); ++one) (*one)->discard();
}

}  // namespace batten
