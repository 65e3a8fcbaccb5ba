// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/temporary_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <string_view>
#include <system_error>
#include <vector>

namespace batten {
namespace fs = std::filesystem;
namespace {

// Registry of guards.

struct Registry {
  std::mutex finishing, changing;
  std::vector<const TemporaryFileGuard*> list;
};

// Never destroyed: the program may terminate while a thread still uses it.
Registry& registry() {
  static auto* const all = new Registry;
  return *all;
}

// The absolute path, because the working directory may change or be removed.
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
  // A thread that is still writing may add files while their folder is being removed.
  constexpr int most_times = 20;
  for (int i = 0; i < most_times && fs::exists(fs::symlink_status(path_, error)); ++i)
    fs::remove_all(path_, error);
}

CommitLock::CommitLock() { registry().finishing.lock(); }
CommitLock::~CommitLock() { registry().finishing.unlock(); }

void remove_temporary_files() {
  Registry& all = registry();
  all.finishing.lock();  // never unlocked
  const std::lock_guard lock(all.changing);
  for (auto one = all.list.rbegin(); one != all.list.rend(); ++one) (*one)->discard();
}

namespace {

// Names: ".STEM.SYSTEM-RANDOM".

constexpr char kLockName[] = ".lock";

constexpr size_t kSystemDigits = 8, kRandomDigits = 16,
                 kMarkLength = kSystemDigits + 1 + kRandomDigits;

std::string hexadecimal(std::uint64_t value, size_t digits) {
  std::string text(digits, '0');
  for (auto digit = text.rbegin(); digit != text.rend(); ++digit, value >>= 4)
    *digit = "0123456789abcdef"[value & 15];
  return text;
}

// Identifies the running operating system: processes see each other's locks if they have the same.
const std::string& system_mark() {
  static const std::string mark = [] {
    std::string id;
    std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), id);
    if (id.empty()) {
      std::array<char, 256> host{};
      ::gethostname(host.data(), host.size() - 1);
      id = host.data();
    }
    std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
    for (const char c : id) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return hexadecimal(hash, kSystemDigits);
  }();
  return mark;
}

std::uint64_t random_number() {
  std::uint64_t value = 0;
  if (::getrandom(&value, sizeof value, 0) != sizeof value)
    throw std::system_error(errno, std::generic_category());
  return value;
}

bool is_mark(std::string_view text) {
  if (text.size() != kMarkLength || text[kSystemDigits] != '-') return false;
  for (size_t i = 0; i < text.size(); ++i)
    if (i != kSystemDigits && std::string_view("0123456789abcdef").find(text[i]) == text.npos)
      return false;
  return true;
}

bool has_mark(std::string_view name) {
  return name.size() > kMarkLength + 2 && name.front() == '.' &&
         name[name.size() - kMarkLength - 1] == '.' &&
         is_mark(name.substr(name.size() - kMarkLength));
}

// Locks.

// Locks an open file. Returns 0 or errno; EWOULDBLOCK: another process holds the lock.
int lock(int file, bool waits) {
  while (::flock(file, LOCK_EX | (waits ? 0 : LOCK_NB)) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

// True if an open file still has this name.
bool has_name(int file, const fs::path& name) {
  struct stat open {
  }, named{};
  return ::fstat(file, &open) == 0 && ::lstat(name.c_str(), &named) == 0 &&
         open.st_dev == named.st_dev && open.st_ino == named.st_ino;
}

// Removes a temporary folder if no process of this system holds its lock.
void remove_unlocked(const fs::path& path) {
  std::error_code ignored;
  const fs::path locked = path / kLockName;
  const int file = ::open(locked.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) {
    // A process is creating or removing it, or was killed there: then it is empty.
    fs::remove(path, ignored);
    return;
  }
  if (lock(file, false) == 0 && has_name(file, locked)) fs::remove_all(path, ignored);
  ::close(file);
}

void remove_leftovers(const fs::path& parent, const std::string& stem) {
  constexpr auto kForeignAge = std::chrono::hours(24 * 7);
  const std::string begin = "." + stem + ".";
  std::error_code error, ignored;
  for (fs::directory_iterator entry(parent, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() != begin.size() + kMarkLength || !name.starts_with(begin) || !has_mark(name) ||
        !fs::is_directory(entry->symlink_status(ignored)))
      continue;
    if (name.compare(begin.size(), kSystemDigits, system_mark()) == 0) {
      remove_unlocked(entry->path());
      continue;
    }
    const auto changed = fs::last_write_time(entry->path(), ignored);
    if (!ignored && fs::file_time_type::clock::now() - changed > kForeignAge)
      fs::remove_all(entry->path(), ignored);
  }
}

// Creates a folder that did not exist, and its lock file. Returns the open lock file, or -1 and
// sets errno.
int create_folder(const fs::path& path) {
  if (::mkdir(path.c_str(), 0700) != 0) return -1;
  const int file = ::open((path / kLockName).c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  const int reason = errno;
  if (file < 0) ::rmdir(path.c_str());
  errno = reason;
  return file;
}

}  // namespace

TemporaryFolder::TemporaryFolder(const fs::path& parent, const std::string& stem) {
  remove_leftovers(parent, stem);
  // Another process may take the new folder for a leftover before it is locked, and remove it.
  constexpr int attempts = 100;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    path_ = parent /
            ("." + stem + "." + system_mark() + "-" + hexadecimal(random_number(), kRandomDigits));
    guard_.emplace(path_);
    errno = 0;
    lock_ = create_folder(path_);
    if (lock_ < 0 && (errno == EEXIST || errno == ENOENT)) continue;
    if (lock_ < 0) break;
    // Without locks in the file system, no other process can lock and remove the folder, either.
    if (lock(lock_, false) != EWOULDBLOCK && has_name(lock_, path_ / kLockName)) return;
    ::close(lock_);
    lock_ = -1;
  }
  throw std::system_error(errno ? errno : ENOENT, std::generic_category());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

fs::path TemporaryFolder::lock_file() const { return path_ / kLockName; }

std::vector<fs::path> TemporaryFolder::remains() const {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(path_, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->is_directory(error)) folders.push_back(entry->path());
  std::reverse(folders.begin(), folders.end());
  folders.insert(folders.end(), {lock_file(), path_});
  return folders;
}

bool is_temporary(const fs::path& path) {
  return std::any_of(path.begin(), path.end(),
                     [](const fs::path& component) { return has_mark(component.native()); });
}

std::string temporary_stem(const fs::path& path) {
  std::string stem;
  for (const fs::path& component : path)
    if (const std::string& name = component.native(); has_mark(name))
      stem = name.substr(1, name.size() - kMarkLength - 2);
  return stem;
}

fs::path without_temporary_folders(const fs::path& path) {
  fs::path shown;
  for (const fs::path& component : path)
    if (!has_mark(component.native())) shown /= component;
  return shown;
}

FolderLock::FolderLock(const fs::path& folder) : file_(folder / ".batten-lock") {
  for (;;) {
    lock_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (lock_ < 0) throw std::system_error(errno, std::generic_category());
    if (const int reason = lock(lock_, true)) {
      ::close(lock_);
      throw std::system_error(reason, std::generic_category());
    }
    // The process that held the lock before has removed the file.
    if (has_name(lock_, file_)) return;
    ::close(lock_);
  }
}

FolderLock::~FolderLock() {
  if (has_name(lock_, file_)) ::unlink(file_.c_str());
  ::close(lock_);
}

}  // namespace batten
