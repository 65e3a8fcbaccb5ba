// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <locale>
#include <system_error>

#include "batten/core/errors.h"
#include "batten/core/log.h"
#include "batten/io/files/command_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw FileError(without_temporary_folders(path).string() + ": cannot write this file: " + reason);
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// The file behind a chain of symbolic links, the last of which may name a file that does not exist.
fs::path behind_links(fs::path path) {
  constexpr int kMaxLinks = 40;  // as in Linux
  std::error_code error;
  const fs::path first = path;
  for (int i = 0; i < kMaxLinks && fs::is_symlink(fs::symlink_status(path, error)); ++i) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) fail(first, error.message());
    path = next.is_absolute() ? next : folder_of(path) / next;
  }
  if (fs::is_symlink(fs::symlink_status(path, error)))
    fail(first, "found a cycle of symbolic links");
  return path;
}

// Gives a new file the permissions of the file that it will replace, and its owner if permitted.
void adopt_permissions(const fs::path& from, const fs::path& existing) {
  struct stat old {
  }, now{};
  if (::stat(existing.c_str(), &old) != 0 || ::stat(from.c_str(), &now) != 0) return;
  if (old.st_uid != now.st_uid || old.st_gid != now.st_gid)
    (void)!::chown(from.c_str(), old.st_uid, old.st_gid);
  constexpr mode_t kPermissions = 07777;
  if (::chmod(from.c_str(), old.st_mode & kPermissions) != 0) fail(existing, std::strerror(errno));
}

// Writes the contents of a file, or the entries of a folder, from the caches to the disk. File
// systems on a network report a full disk only here.
void flush_to_disk(const fs::path& path, const fs::path& shown) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(shown, std::strerror(errno));
  const int reason = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  if (reason == EIO || reason == ENOSPC || reason == EDQUOT) fail(shown, std::strerror(reason));
}

void flush_folder(const fs::path& folder) noexcept {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

thread_local int deferred_flushes = 0;

}  // namespace

DeferredFlush::DeferredFlush() { ++deferred_flushes; }
DeferredFlush::~DeferredFlush() { --deferred_flushes; }

void DeferredFlush::flush(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) fail(folder, std::strerror(errno));
  const int reason = ::syncfs(file) == 0 ? 0 : errno;
  ::close(file);
  if (reason == EIO || reason == ENOSPC || reason == EDQUOT) fail(folder, std::strerror(reason));
}

fs::path replaceable_file(const fs::path& path) {
  if (!path.has_filename()) fail(path, "found the name of a folder, expected a file name");
  const fs::path target = behind_links(path);
  struct stat found {};
  if (::stat(target.c_str(), &found) == 0) {
    if (S_ISDIR(found.st_mode)) fail(path, "found a folder of this name");
    if (!S_ISREG(found.st_mode)) fail(path, "it is not a regular file");
    require_not_input(target, path);
    if ((found.st_mode & (S_IWUSR | S_IWGRP | S_IWOTH)) == 0)
      fail(path, "found a write-protected file of this name, expected a writable one");
    if (found.st_nlink > 1)
      fail(path, "found a file with " + std::to_string(found.st_nlink) +
                     " names (hard links), expected another name, or delete this one first");
    return target;
  }
  const fs::path folder = folder_of(target);
  std::error_code error;
  const fs::file_status above = fs::status(folder, error);
  if (!fs::exists(above)) fail(path, "the folder " + folder.string() + " does not exist");
  if (!fs::is_directory(above)) fail(path, folder.string() + " is not a folder");
  return target;
}

AtomicFile::AtomicFile(fs::path path) : path_(replaceable_file(path)) {
  // Truncate long names, so that the mark fits.
  constexpr size_t kMaxStem = 100;
  try {
    folder_.emplace(folder_of(path_), path_.filename().string().substr(0, kMaxStem));
  } catch (const std::system_error& e) {
    fail(path, e.code().message());
  }
  temporary_ = folder_->path() / path_.filename();
}

void AtomicFile::write(const std::function<void(std::ostream&)>& write) {
  errno = 0;
  std::ofstream out(temporary(), std::ios::binary);
  out.imbue(std::locale::classic());
  if (out) write(out);
  out.close();
  if (!out) fail(path_, errno ? std::strerror(errno) : "writing failed");
}

void AtomicFile::commit() {
  std::error_code error;
  const bool of_run = temporary_stem(path_.parent_path()) == kRunStem;
  replaceable_file(path_);
  adopt_permissions(temporary(), path_);
  const bool flushes = !of_run && deferred_flushes == 0;  // the files of a run are flushed together
  if (flushes) flush_to_disk(temporary(), path_);
  {
    const CommitLock lock;
    fs::rename(temporary(), path_, error);
  }
  if (error) fail(path_, error.message());
  folder_.reset();
  if (flushes) flush_folder(folder_of(path_));
  log(LogLevel::Info, [&] { return "wrote " + path_.string(); });
}

void write_file_atomically(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  AtomicFile file(path);
  file.write(write);
  file.commit();
}

namespace {

// One renaming, as strings that a child process can use without allocating memory.
struct Renaming {
  std::string from, to;
  enum class Done { Nothing, Renamed, Exchanged } done = Done::Nothing;

  // Returns 0 or errno. An existing file gets the name `from`, so that undo() can restore it.
  int perform() {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0) {
      done = Done::Exchanged;
      return 0;
    }
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) {
      done = Done::Renamed;
      return 0;
    }
    // The file system has neither operation: the existing file cannot be restored.
    return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
  }
  void undo() const {
    if (done == Done::Exchanged)
      ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE);
    if (done == Done::Renamed) ::rename(to.c_str(), from.c_str());
  }
};

struct Failure {
  int index = -1, reason = 0;
};

// Performs all renamings or none. Uses only async-signal-safe functions.
Failure rename_all(std::vector<Renaming>& all, const std::vector<std::string>& removed) {
  // A missing last file tells that the set is incomplete.
  const Renaming& last = all.front();
  const bool had_last = ::rename(last.to.c_str(), last.from.c_str()) == 0;
  for (size_t i = 1; i < all.size(); ++i)
    if (const int reason = all[i].perform()) {
      for (size_t k = i; k-- > 1;) all[k].undo();
      if (had_last) ::rename(last.from.c_str(), last.to.c_str());
      return {static_cast<int>(i), reason};
    }
  if (had_last) ::unlink(last.from.c_str());
  for (const Renaming& one : all)
    if (one.done == Renaming::Done::Exchanged) ::unlink(one.from.c_str());
  for (const std::string& path : removed) ::remove(path.c_str());
  return {};
}

// rename_all() in a child process, which ends its work even if this process is killed.
Failure rename_all_in_child(std::vector<Renaming>& all, const std::vector<std::string>& removed) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return rename_all(all, removed);
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return rename_all(all, removed);
  }
  if (child == 0) {
    ::setsid();
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGALRM})
      ::signal(number, SIG_IGN);
    const Failure failure = rename_all(all, removed);
    (void)!::write(ends[1], &failure, sizeof failure);
    ::_exit(0);
  }
  ::close(ends[1]);
  Failure failure;
  ssize_t got = 0;
  while ((got = ::read(ends[0], &failure, sizeof failure)) < 0 && errno == EINTR) {
  }
  ::close(ends[0]);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (got != sizeof failure) return {0, EINTR};
  return failure;
}

}  // namespace

void move_together(const std::vector<FileMove>& moves, const std::vector<fs::path>& removed) {
  if (moves.empty()) return;
  std::vector<Renaming> renamings;
  // First the place for an old last file, then all files in order.
  renamings.push_back({moves.back().from.string() + ".old", moves.back().to.string()});
  for (const FileMove& move : moves) {
    adopt_permissions(move.from, move.to);
    renamings.push_back({move.from.string(), move.to.string()});
  }
  for (const FileMove& move : moves) flush_to_disk(move.from, move.to);
  std::vector<std::string> removals;
  for (const fs::path& path : removed) removals.push_back(path.string());
  Failure failure;
  {
    const CommitLock lock;
    failure = rename_all_in_child(renamings, removals);
  }
  if (failure.index >= 0)
    fail(renamings[static_cast<size_t>(failure.index)].to, std::strerror(failure.reason));
  std::string flushed;
  for (const FileMove& move : moves) {
    log(LogLevel::Info, [&] { return "wrote " + move.to.string(); });
    if (const fs::path folder = folder_of(move.to); folder.native() != flushed)
      flush_folder(folder), flushed = folder.native();
  }
}

void require_distinct(const std::vector<const AtomicFile*>& files) {
  for (size_t i = 0; i < files.size(); ++i)
    for (size_t k = 0; k < i; ++k)
      if (fs::weakly_canonical(files[i]->path()) == fs::weakly_canonical(files[k]->path()))
        throw InputError(files[i]->path().string() +
                         ": found two output files of this name, expected different names");
}

void commit_together(const std::vector<const AtomicFile*>& files) {
  std::vector<FileMove> moves;
  std::vector<fs::path> removed;
  for (const AtomicFile* file : files) {
    std::error_code error;
    if (!fs::exists(file->temporary(), error)) continue;
    moves.push_back({file->temporary(), replaceable_file(file->path())});
    const auto remains = file->folder().remains();
    removed.insert(removed.end(), remains.begin(), remains.end());
  }
  move_together(moves, removed);
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
  try {
    const TemporaryFolder probe(path, "probe");
  } catch (const std::system_error& e) {
    refuse(e.code().message());
  }
}

}  // namespace batten
