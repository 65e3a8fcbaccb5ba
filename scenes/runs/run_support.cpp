// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/runs/run_support.h"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <set>
#include <system_error>

#include "batten/io/files/text.h"
#include "batten/io/pictures/display.h"

namespace batten {
namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  for (fs::path p = fs::absolute(folder_); !p.empty() && !fs::exists(p, error) && !error;
       p = p.parent_path())
    if (p.has_filename()) made_.insert(made_.begin(), p);
  for (const fs::path& p : made_) unfinished_.emplace_back(p, TemporaryFileGuard::Content::Keep);
  make_output_folder(folder_);
  try {
    hidden_.emplace(folder_, kRunStem);
  } catch (const std::system_error& e) {
    throw FileError(folder_.string() + ": cannot use this output folder: " + e.code().message());
  }
}

OutputFolder::~OutputFolder() {
  hidden_.reset();
  std::error_code ignored;
  if (!committed_)
    // removes empty folders only
    for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);
}

void OutputFolder::require_replaceable(const std::vector<std::string>& names) const {
  std::set<std::string> found;
  for (const std::string& name : names) {
    if (name.empty()) continue;
    if (!found.insert(fs::path(name).lexically_normal().string()).second)
      throw InputError((folder_ / name).string() +
                       ": found two output files of this name, expected different names");
    if (fs::exists((folder_ / name).parent_path())) replaceable_file(folder_ / name);
  }
}

namespace {

// The names of the files in a temporary folder, relative to it, in alphabetical order, and `last`
// at the end.
std::vector<fs::path> files_in(const TemporaryFolder& hidden, const std::string& last) {
  std::vector<fs::path> names;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(hidden.path(), error), end; !error && entry != end;
       entry.increment(error))
    if (!entry->is_directory(error) && entry->path() != hidden.lock_file())
      names.push_back(entry->path().lexically_relative(hidden.path()));
  if (error)
    throw FileError(hidden.path().string() + ": cannot read this folder: " + error.message());
  std::sort(names.begin(), names.end());
  const auto found = std::find(names.begin(), names.end(), last);
  if (found != names.end()) std::rotate(found, found + 1, names.end());
  return names;
}

// Copies a file to the file system of its destination, where it can be renamed.
std::unique_ptr<AtomicFile> copy_beside(const fs::path& from, const fs::path& to) {
  auto copy = std::make_unique<AtomicFile>(to);
  std::error_code error;
  fs::copy_file(from, copy->temporary(), fs::copy_options::overwrite_existing, error);
  if (error) throw FileError(to.string() + ": cannot write this file: " + error.message());
  return copy;
}

dev_t device_of(const fs::path& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 ? found.st_dev : 0;
}

}  // namespace

void OutputFolder::commit(const std::string& last, AtomicFile* beside) {
  const std::vector<fs::path> names = files_in(*hidden_, last);
  std::optional<FolderLock> turn;
  try {
    turn.emplace(folder_);
  } catch (const std::system_error& e) {
    throw FileError(
        folder_.string() +
        ": cannot lock this folder, so that files of two runs could mix: " + e.code().message());
  }
  std::vector<FileMove> moves;
  std::vector<std::unique_ptr<AtomicFile>> copies;
  if (beside) moves.push_back({beside->temporary(), replaceable_file(beside->path())});
  for (const fs::path& name : names) {
    std::error_code error;
    if (name.has_parent_path()) fs::create_directories((folder_ / name).parent_path(), error);
    FileMove move{hidden_->path() / name, replaceable_file(folder_ / name)};
    if (device_of(move.to.parent_path()) != device_of(move.from.parent_path())) {
      copies.push_back(copy_beside(move.from, move.to));
      move.from = copies.back()->temporary();
    }
    moves.push_back(std::move(move));
  }
  std::vector<fs::path> removed = hidden_->remains();
  removed.push_back(turn->file());
  move_together(moves, removed);
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

ParameterSweep parse_range(const std::string& option, const std::string& text, int default_count) {
  ParameterSweep range;
  range.where = option + " " + text + ": ";
  const auto fail = [&](const std::string& found) {
    throw InputError(range.where + "found " + found + ", expected NAME=FROM:TO" +
                     (default_count > 0 ? " or NAME=FROM:TO:COUNT" : ":COUNT"));
  };
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) fail("no name");
  range.parameter = text.substr(0, equals);
  std::vector<double> numbers;
  for (size_t at = equals + 1; at <= text.size();) {
    const size_t colon = std::min(text.find(':', at), text.size());
    const std::string word = text.substr(at, colon - at);
    const std::optional<double> value = parse_number(word);
    if (!value) fail("'" + word + "' for a number");
    numbers.push_back(*value);
    at = colon + 1;
  }
  if (numbers.size() == 2 && default_count > 0) numbers.push_back(default_count);
  if (numbers.size() != 3) fail(std::to_string(numbers.size()) + " numbers");
  constexpr double most = 1000;
  if (numbers[2] != std::floor(numbers[2]) || numbers[2] < 2 || numbers[2] > most)
    throw InputError(range.where + "found " + format_number(numbers[2]) +
                     " values, expected a whole number from 2 to 1000");
  if (numbers[0] == numbers[1])
    throw InputError(range.where + "found an empty range, " + format_number(numbers[0]) +
                     " at both ends, expected two different values");
  range.from = numbers[0];
  range.to = numbers[1];
  range.count = static_cast<int>(numbers[2]);
  return range;
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
  return "  " + label + std::string(12 - label.size(), ' ') + printable(text) + "\n";
}

namespace {

/// The name of a numbered file without its number, "sweep_#.vtp", "variant-#/mesh.bdf"; empty: the
/// file has no number of three or more digits.
std::string series_of(const std::string& file) {
  for (size_t at = file.find_first_of("_-"); at != std::string::npos;
       at = file.find_first_of("_-", at + 1)) {
    const size_t end = file.find_first_not_of("0123456789", at + 1);
    if (end == std::string::npos || end < at + 4 || (file[end] != '.' && file[end] != '/'))
      continue;
    return file.substr(0, at + 1) + "#" + file.substr(end);
  }
  return "";
}

/// Files, with one entry for each series of numbered files.
std::vector<std::string> abbreviated(const std::vector<std::string>& files) {
  struct Series {
    size_t entry;
    int count;
  };
  std::map<std::string, Series> known;
  std::vector<std::string> list, last;
  for (const std::string& file : files) {
    const std::string name = series_of(file);
    const auto [series, added] = known.try_emplace(name, Series{list.size(), 0});
    ++series->second.count;
    if (name.empty() || added) {
      list.push_back(file);
      last.push_back(file);
    } else {
      last[series->second.entry] = file;
    }
  }
  for (const auto& [name, series] : known)
    if (!name.empty() && series.count > 1)
      list[series.entry] += " … " + last[series.entry] + " (" + std::to_string(series.count) + ")";
  return list;
}

}  // namespace

std::string summary_footer(const RunReport& report, const std::filesystem::path& folder) {
  std::string text;
  for (const auto& [stage, seconds] : report.timings)
    if (stage == "total") text += summary_line("time", format_number(seconds) + " s");
  text += "files in " + printable(folder.string()) + ":\n";
  for (const auto& file : abbreviated(report.files)) text += "  " + printable(file) + "\n";
  return text;
}

}  // namespace batten
