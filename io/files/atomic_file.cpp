// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <fstream>
#include <locale>
#include <mutex>
#include <system_error>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/log.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw FileError(path.string() + ": cannot write this file: " + reason);
}

/// A temporary name that no other process or thread uses: it contains the process id and a counter.
/// The leading dot hides it from "*".
fs::path temporary_name(const fs::path& folder, const std::string& stem,
                        const std::string& extension) {
  static std::atomic<int> counter{0};
  return folder / ("." + stem + "." + std::to_string(getpid()) + "-" + std::to_string(++counter) +
                   extension);
}

/// Removes the temporary files of processes that no longer exist.
void remove_orphans(const fs::path& folder, const std::string& stem, const std::string& extension) {
  const std::string begin = "." + stem + ".";
  std::error_code error, ignored;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin) || !name.ends_with(extension)) continue;
    const char *first = name.data() + begin.size(), *last = name.data() + name.size();
    long process = 0, count = 0;
    const auto [dash, bad] = std::from_chars(first, last, process);
    if (bad != std::errc() || process <= 0 || dash == last || *dash != '-') continue;
    const auto [rest, worse] = std::from_chars(dash + 1, last, count);
    if (worse != std::errc() || std::string(rest, last) != extension) continue;
    if (::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
      fs::remove(entry->path(), ignored);
  }
}

/// Creates an empty file. Returns 0 or errno.
int create(const fs::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  ::close(file);
  return 0;
}

}  // namespace

AtomicFile::AtomicFile(fs::path path) : path_(std::move(path)) {
  if (!path_.has_filename()) fail(path_, "found the name of a folder, expected a file name");
  std::error_code error;
  const fs::file_status found = fs::status(path_, error);
  if (fs::is_directory(found)) fail(path_, "found a folder of this name");
  if (fs::exists(found) && !fs::is_regular_file(found)) fail(path_, "it is not a regular file");
  // Renaming to the name of a symbolic link would replace the link, not its target.
  fs::path target = fs::exists(found) ? fs::canonical(path_, error) : path_;
  if (error) target = path_;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const fs::file_status above = fs::status(folder, error);
  if (!fs::exists(above)) fail(path_, "the folder " + folder.string() + " does not exist");
  if (!fs::is_directory(above)) fail(path_, folder.string() + " is not a folder");
  // Truncate long names, so that the suffix fits.
  const std::string stem = target.stem().string().substr(0, 100),
                    extension = target.extension().string();
  remove_orphans(folder, stem, extension);
  temporary_ = temporary_name(folder, stem, extension);
  path_ = target;
  guard_.emplace(temporary_);
  if (const int reason = create(temporary_)) fail(path_, std::strerror(reason));
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  std::error_code error;
  commit_files([&] { fs::rename(temporary_, path_, error); });
  if (error) fail(path_, error.message());
  temporary_.clear();
  log(LogLevel::Info, [&] { return "wrote " + path_.string(); });
}

void write_file_atomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  AtomicFile file(path);
  errno = 0;
  std::ofstream out(file.temporary(), std::ios::binary);
  out.imbue(std::locale::classic());
  write(out);
  out.close();
  if (!out) fail(path, errno ? std::strerror(errno) : "writing failed");
  file.commit();
}

void make_output_folder(const fs::path& path) {
  const auto refuse = [&](const std::string& reason) {
    throw FileError(path.string() + ": cannot use this output folder: " + reason);
  };
  if (path.empty()) refuse("its name is empty");
  std::error_code error;
  const fs::file_status found = fs::status(path, error);
  if (fs::exists(found) && !fs::is_directory(found)) refuse("found a file of this name");
  if (!fs::exists(found)) {
    fs::create_directories(path, error);
    std::error_code ignored;
    if (error && !fs::is_directory(path, ignored)) refuse(error.message());
  }
  const fs::path probe = temporary_name(path, "probe", "");
  if (const int reason = create(probe)) refuse(std::strerror(reason));
  fs::remove(probe, error);
}

namespace {

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

void commit_files(const std::function<void()>& move) {
  const std::lock_guard lock(registry().finishing);
  move();
}

void remove_temporary_files() {
  Registry& all = registry();
  all.finishing.lock();  // never unlocked
  const std::lock_guard lock(all.changing);
  for (auto one = all.list.rbegin(); one != all.list.rend(); ++one) (*one)->discard();
}

}  // namespace batten
