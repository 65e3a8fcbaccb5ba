// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/runs/run_support.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "batten/io/pictures/display.h"

namespace batten {
namespace fs = std::filesystem;

namespace {

const std::string kHidden = ".batten-";

// Opens a folder and locks it. Returns -1 if another process holds the lock and `waits` is false,
// or if the file system does not support locks.
int locked_folder(const fs::path& folder, bool waits) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return -1;
  while (::flock(file, LOCK_EX | (waits ? 0 : LOCK_NB)) != 0) {
    if (errno == EINTR) continue;
    ::close(file);
    return -1;
  }
  return file;
}

// Removes hidden folders of killed runs: nobody holds their locks.
void remove_orphans(const fs::path& folder) {
  std::error_code error, ignored;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->path().filename().string().starts_with(kHidden)) continue;
    if (const int lock = locked_folder(entry->path(), false); lock >= 0) {
      fs::remove_all(entry->path(), ignored);
      ::close(lock);
    }
  }
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  for (fs::path p = fs::absolute(folder_); !p.empty() && !fs::exists(p, error) && !error;
       p = p.parent_path())
    if (p.has_filename()) made_.insert(made_.begin(), p);
  hidden_ = folder_ / (kHidden + std::to_string(getpid()));
  for (const fs::path& p : made_) unfinished_.emplace_back(p, TemporaryFileGuard::Content::Keep);
  unfinished_.emplace_back(hidden_);
  make_output_folder(folder_);
  {
    // Serialised, so that no run mistakes a folder that is not locked yet for an orphan.
    const int turn = locked_folder(folder_, true);
    remove_orphans(folder_);
    fs::create_directory(hidden_, error);
    if (!error) lock_ = locked_folder(hidden_, false);
    if (turn >= 0) ::close(turn);
  }
  if (error) throw InputError(hidden_.string() + ": cannot create this folder: " + error.message());
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(hidden_, ignored);
  if (lock_ >= 0) ::close(lock_);
  if (!committed_)
    // removes empty folders only
    for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);
}

void OutputFolder::commit() {
  // Files in subfolders are moved one by one, because a subfolder may exist from an earlier run.
  std::vector<fs::path> names;
  std::error_code unread;
  for (fs::recursive_directory_iterator entry(hidden_, unread), end; !unread && entry != end;
       entry.increment(unread))
    if (!entry->is_directory(unread)) names.push_back(entry->path().lexically_relative(hidden_));
  if (unread) throw InputError(hidden_.string() + ": cannot read this folder: " + unread.message());
  for (const auto& name : names)
    if (fs::is_directory(folder_ / name, unread))
      throw FileError((folder_ / name).string() +
                      ": cannot write this file: found a folder of this name");
  commit_files([&] {
    const int turn = locked_folder(folder_, true);
    std::string failure;
    for (const auto& name : names) {
      std::error_code error;
      if (name.has_parent_path()) fs::create_directories((folder_ / name).parent_path(), error);
      fs::rename(hidden_ / name, folder_ / name, error);
      if (error && failure.empty())
        failure = (folder_ / name).string() + ": cannot write this file: " + error.message();
    }
    if (turn >= 0) ::close(turn);
    if (!failure.empty()) throw FileError(failure);
  });
  committed_ = true;
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const char* const last = text.data() + text.size();
  // std::from_chars rejects a leading plus.
  const bool plus = text.starts_with('+') && !text.starts_with("+-");
  const auto [end, error] = std::from_chars(text.data() + plus, last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) return {};
  return value;
}

std::vector<Setting> parse_settings(const std::vector<std::string>& settings) {
  std::vector<Setting> parsed;
  for (const std::string& setting : settings) {
    const std::string where = "--set " + setting + ": ";
    const size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError(where + "found no '=', expected NAME=VALUE");
    const std::string text = setting.substr(equals + 1);
    const std::optional<double> value = parse_number(text);
    if (!value) throw InputError(where + "found '" + text + "', expected a number");
    parsed.push_back({setting.substr(0, equals), where, *value});
  }
  return parsed;
}

bool matches_wildcard(const std::string& pattern, const std::string& text) {
  size_t p = 0, t = 0, star = std::string::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string::npos) {  // let the last star match one more character
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

bool can_draw(RunReport& report, const std::string& what) {
  try {
    require_display();
    return true;
  } catch (const InputError& e) {
    report.failed_checks.push_back({what, std::string("is not drawn: ") + e.what()});
    return false;
  }
}

std::string safe_file_name(const std::string& text) {
  std::string word;
  for (const char c : text)
    word += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' ? c : '_';
  return word.empty() ? "surface" : word;
}

std::string summary_line(const std::string& label, const std::string& text) {
  return "  " + label + std::string(12 - label.size(), ' ') + text + "\n";
}

std::string summary_footer(const RunReport& report, const std::filesystem::path& folder) {
  std::string text;
  for (const auto& [stage, seconds] : report.timings)
    if (stage == "total") text += summary_line("time", format_number(seconds) + " s");
  text += "files in " + folder.string() + ":\n";
  for (const auto& file : report.files) text += "  " + file + "\n";
  return text;
}

}  // namespace batten
