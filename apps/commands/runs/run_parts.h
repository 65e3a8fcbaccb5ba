// Functions that all commands share.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/errors.h"

namespace batten {

/// Measures the seconds of each stage of a run: lap() ends a stage, total() the run.
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

/// One "name=value" of the command line. Messages about it begin with `where`.
struct Setting {
  std::string name, where;
  double value;
};
/// Parses words "name=value". Throws InputError: no '=', no name, a value that is not a finite
/// number.
std::vector<Setting> parsed_settings(const std::vector<std::string>& settings);

/// Whether a text fits a pattern, in which '*' stands for any letters. O(product of the lengths).
bool matches(const std::string& pattern, const std::string& text);

/// A line of a summary: the label in 12 columns, and the text.
std::string result_line(const std::string& label, const std::string& text);

/// The end of a summary of any kind of report: the time it took, and the files.
template <class AnyReport>
std::string result_ending(const AnyReport& report, const std::filesystem::path& folder) {
  std::string text;
  for (const auto& [stage, seconds] : report.timings)
    if (stage == "total") text += result_line("time", number(seconds) + " s");
  text += "files in " + folder.string() + ":\n";
  for (const auto& file : report.files) text += "  " + file + "\n";
  return text;
}

}  // namespace batten
