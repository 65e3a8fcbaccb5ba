// SPDX-License-Identifier: MPL-2.0
// Functions shared by all commands: output folder, timing, settings, reports.
#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/progress.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/report/run_report.h"

namespace batten {

/// Output folder of a run whose files appear all or none. Files are written into a hidden
/// subfolder, and commit() moves them to their final names.
///
/// Without a commit, the destructor (or remove_temporary_files()) removes them, and the folders
/// that the constructor created; files of earlier runs are unchanged. Runs into the same folder may
/// overlap, also on machines that share it: each moves its files while it holds a lock, and the last
/// one wins. Leftovers of a killed run are removed by the next run (TemporaryFolder).
class OutputFolder {
 public:
  /// Creates the folder and its parents. Throws FileError if it is not writable.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Path at which to write a file before commit(). Subfolders may be created beside it; their
  /// contents are moved to subfolders of the same names.
  std::filesystem::path file(const std::string& name) const { return hidden_->path() / name; }
  /// The output folder.
  const std::filesystem::path& folder() const { return folder_; }
  /// Checks before a long computation that files of these names may be replaced. Empty names are
  /// ignored. Throws InputError if two names are equal, and the exceptions of replaceable_file().
  void require_replaceable(const std::vector<std::string>& names) const;
  /// Moves all files to their final names, all or none, and the file `last` at the end
  /// (move_together()). Call it once. `beside`: a file in another folder that belongs to the
  /// results; null: none. Throws FileError, also if the folder cannot be locked.
  void commit(const std::string& last = "report.json", AtomicFile* beside = nullptr);

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_;   // created folders, outermost first
  std::list<TemporaryFileGuard> unfinished_;  // guards for all of these
  std::optional<TemporaryFolder> hidden_;
  bool committed_ = false;
};

/// Seconds since a time point.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Measures the duration of the stages of a run, in seconds: lap() ends a stage, total() the run.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<std::string, double>>& timings) : timings_(timings) {}
  void lap(const std::string& stage) {
    timings_.emplace_back(stage, seconds_since(last_));
    last_ = Clock::now();
  }
  void total() { timings_.emplace_back("total", seconds_since(start_)); }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<std::pair<std::string, double>>& timings_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

/// One "name=value" argument of the command line. Messages about it begin with `where`.
struct Setting {
  std::string name, where;
  double value;
};
/// Values of one parameter, "NAME=FROM:TO:COUNT" on the command line. Messages about it begin with
/// `where`.
struct ParameterSweep {
  std::string parameter, where;
  double from = 0, to = 0;
  int count = 0;
  /// The i-th of `count` values, equally spaced from end to end.
  double at(int i) const { return from + (to - from) * i / std::max(1, count - 1); }
};
/// Parses "NAME=FROM:TO:COUNT"; `option`: its name in messages. `default_count`: count of
/// "NAME=FROM:TO"; 0: COUNT is required. Throws InputError for invalid text, a count that is not a
/// whole number from 2 to 1000, and an empty range.
ParameterSweep parse_range(const std::string& option, const std::string& text,
                           int default_count = 0);
/// Parses a text as one finite number, independently of the locale ("0.5"); empty if it is none.
std::optional<double> parse_number(std::string_view text);
/// Parses arguments "name=value". Throws InputError for a missing '=', a missing name, or a value
/// that is not a finite number.
std::vector<Setting> parse_settings(const std::vector<std::string>& settings);
/// Sets parameters of any kind of scene from "name=value" arguments, in order. Throws InputError.
template <class AnyScene>
void apply_settings(AnyScene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parse_settings(settings)) scene.set(s.name, s.value, s.where);
}

/// True if pictures can be drawn. Without a display it returns false and adds `what` to
/// report.failed_checks; the result is kept.
bool can_draw(RunReport& report, const std::string& what);

/// Adds failed checks to any kind of report, and writes it as JSON into the folder.
template <class AnyReport>
void write_report(AnyReport& report, const std::vector<FailedCheck>& failed,
                  const OutputFolder& out, const Progress& progress,
                  const std::string& name = "report.json") {
  report.failed_checks.insert(report.failed_checks.end(), failed.begin(), failed.end());
  report.files.push_back(name);
  write_file_atomically(out.file(name), [&](std::ostream& text) { text << to_json(report); });
  progress.update("files", 1);
}

/// True if a text matches a pattern with '*' as a wildcard. Cost: O(product of the lengths).
bool matches_wildcard(const std::string& pattern, const std::string& text);

/// Converts a text to a file name that all file systems and shells accept.
std::string safe_file_name(const std::string& text);

/// A line of a summary: the label padded to 12 columns, and the text.
std::string summary_line(const std::string& label, const std::string& text);

/// The end of a summary of any kind of report: run time and files. Series of numbered files, such as
/// frames, take one line each.
std::string summary_footer(const RunReport& report, const std::filesystem::path& folder);

}  // namespace batten
