// What all commands share.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/errors.h"
#include "batten/core/progress.h"
#include "batten/io/files/whole_file.h"
#include "batten/io/report/report_parts.h"

namespace batten {

/// Files are written into a hidden folder inside the output folder and moved to their names by
/// commit(). Without it they are removed, files of earlier runs stay as they were, and folders that
/// did not exist before are gone again.
class OutputFolder {
 public:
  /// Makes the folder and those above it. Throws InputError when it cannot be written to.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to write the file of this name until commit().
  std::filesystem::path file(const std::string& name) const { return hidden_ / name; }
  const std::filesystem::path& folder() const { return folder_; }
  /// Call once. Throws InputError, before anything is moved, when a name is taken by a folder.
  void commit();

 private:
  std::filesystem::path folder_, hidden_;
  std::vector<std::filesystem::path> made_;  // outermost first
  bool committed_ = false;
};

/// Seconds of each stage of a run.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<std::string, double>>& timings) : timings_(timings) {}
  void lap(const std::string& stage) {
    const auto now = Clock::now();
    timings_.emplace_back(stage, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  void total() {
    timings_.emplace_back("total", std::chrono::duration<double>(Clock::now() - start_).count());
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::vector<std::pair<std::string, double>>& timings_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

/// One "name=value" of the command line; messages about it begin with `where`.
struct Setting {
  std::string name, where;
  double value;
};
/// Throws InputError.
std::vector<Setting> parsed_settings(const std::vector<std::string>& settings);
/// "name=value" words of the command line, put into any kind of scene in their order. Throws
/// InputError.
template <class AnyScene>
void apply_settings(AnyScene& scene, const std::vector<std::string>& settings) {
  for (const Setting& s : parsed_settings(settings)) scene.set(s.name, s.value, s.where);
}

/// Whether pictures can be drawn; false, and `what` missed, when there is no display: a result
/// without them is still a result, but not what was asked for.
bool can_draw(RunReport& report, const std::string& what);

/// Puts the promises that are broken into any kind of report, and the report into the folder.
template <class AnyReport>
void write_report(AnyReport& report, const std::vector<MissedPromise>& broken,
                  const OutputFolder& out, const Progress& progress) {
  report.missed.insert(report.missed.end(), broken.begin(), broken.end());
  report.files.push_back("report.json");
  write_whole_file(out.file("report.json"), [&](std::ostream& text) { text << to_json(report); });
  progress.at("files", 1);
}

/// Whether a name fits a pattern, in which '*' stands for any letters. O(both).
bool matches(const std::string& pattern, const std::string& text);

/// A line of a summary.
std::string result_line(const std::string& label, const std::string& text);

/// The end of a summary: the time it took and the files.
std::string result_ending(const RunReport& report, const std::filesystem::path& folder);

}  // namespace batten
