// Functions that all commands share.
#pragma once

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

/// The output folder of a run: all its files appear, or none. Files are written into a hidden folder
/// inside it, and commit() moves them to their names. Without a commit the destructor, or
/// remove_temporary_files(), removes them and the folders that the constructor made; files of earlier
/// runs stay as they were. Runs into one folder may overlap: each moves all its files at once, and
/// the last one stays. What a killed run left is removed by the next.
class OutputFolder {
 public:
  /// Makes the folder and those above it. Throws InputError when it cannot be written to.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The path at which to write the file of this name before commit(). Folders may be made beside it:
  /// what is in them comes into folders of the same names.
  std::filesystem::path file(const std::string& name) const { return hidden_ / name; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Moves all files to their names. Call it once. Throws InputError, before anything is moved,
  /// when a folder has the name of a file.
  void commit();

 private:
  std::filesystem::path folder_, hidden_;
  int lock_ = -1;                             // of the hidden folder, as long as it is in use
  std::vector<std::filesystem::path> made_;   // folders that were made, outermost first
  std::list<TemporaryFileGuard> unfinished_;  // all of these
  bool committed_ = false;
};

/// Seconds since a moment.
inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Measures the seconds of each stage of a run: lap() ends a stage, total() the run.
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

/// One "name=value" of the command line. Messages about it begin with `where`.
struct Setting {
  std::string name, where;
  double value;
};
/// The finite number that all of a text states, "0.5" in any locale; none where it states none.
std::optional<double> parse_number(std::string_view text);
/// Parses words "name=value". Throws InputError: no '=', no name, a value that is not a finite
/// number.
std::vector<Setting> parse_settings(const std::vector<std::string>& settings);
/// Sets parameters of any kind of scene from "name=value" words of the command line, in their order.
/// Throws InputError.
template <class AnyScene>
void apply_settings(AnyScene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parse_settings(settings)) scene.set(s.name, s.value, s.where);
}

/// Whether pictures can be drawn. When there is no display, it returns false and adds `what` to
/// report.missed: the result is kept.
bool can_draw(RunReport& report, const std::string& what);

/// Adds the broken promises to any kind of report, and writes it as JSON into the folder.
template <class AnyReport>
void write_report(AnyReport& report, const std::vector<FailedCheck>& failed,
                  const OutputFolder& out, const Progress& progress,
                  const std::string& name = "report.json") {
  report.failed_checks.insert(report.failed_checks.end(), failed.begin(), failed.end());
  report.files.push_back(name);
  write_file_atomically(out.file(name), [&](std::ostream& text) { text << to_json(report); });
  progress.update("files", 1);
}

/// Whether a text fits a pattern, in which '*' stands for any letters. O(product of the lengths).
bool matches_wildcard(const std::string& pattern, const std::string& text);

/// A name of letters that every file system and every shell accepts.
std::string safe_file_name(const std::string& text);

/// A line of a summary: the label in 12 columns, and the text.
std::string summary_line(const std::string& label, const std::string& text);

/// The end of a summary of any kind of report: the time it took, and the files.
std::string summary_footer(const RunReport& report, const std::filesystem::path& folder);

}  // namespace batten
