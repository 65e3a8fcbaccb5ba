#include "batten/apps/commands/runs/run_parts.h"

#include <unistd.h>
#include <cmath>
#include <cstdlib>

#include "batten/io/pictures/display.h"

namespace batten {
namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  for (fs::path p = fs::absolute(folder_); !p.empty() && !fs::exists(p, error) && !error;
       p = p.parent_path())
    if (p.has_filename()) made_.insert(made_.begin(), p);
  hidden_ = folder_ / (".batten-" + std::to_string(getpid()));
  for (const fs::path& p : made_) unfinished_.emplace_back(p, Unfinished::Content::Keep);
  unfinished_.emplace_back(hidden_);
  make_output_folder(folder_);
  fs::remove_all(hidden_, error);
  fs::create_directory(hidden_, error);
  if (error) throw InputError(hidden_.string() + ": cannot make this folder: " + error.message());
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(hidden_, ignored);
  if (!committed_)
    for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);  // if empty
}

void OutputFolder::commit() {
  std::vector<fs::path> names;
  for (const auto& entry : fs::directory_iterator(hidden_))
    names.push_back(entry.path().filename());
  for (const auto& name : names)
    if (fs::is_directory(folder_ / name))
      throw InputError((folder_ / name).string() +
                       ": cannot write this file: a folder has this name");
  finish_files([&] {
    for (const auto& name : names) {
      std::error_code error;
      fs::rename(hidden_ / name, folder_ / name, error);
      if (error)
        throw InputError((folder_ / name).string() +
                         ": cannot write this file: " + error.message());
    }
  });
  committed_ = true;
}

std::vector<Setting> parsed_settings(const std::vector<std::string>& settings) {
  std::vector<Setting> parsed;
  for (const std::string& setting : settings) {
    const std::string where = "--set " + setting + ": ";
    const size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError(where + "found no '=', expected name=value");
    const std::string text = setting.substr(equals + 1);
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value))
      throw InputError(where + "found '" + text + "', expected a number");
    parsed.push_back({setting.substr(0, equals), where, value});
  }
  return parsed;
}

bool matches(const std::string& pattern, const std::string& text) {
  size_t p = 0, t = 0, star = std::string::npos, resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && pattern[p] == text[t]) {
      ++p;
      ++t;
    } else if (star != std::string::npos) {  // the last star takes one letter more
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
    report.missed.push_back({what, std::string("is not drawn: ") + e.what()});
    return false;
  }
}

std::string result_line(const std::string& label, const std::string& text) {
  return "  " + label + std::string(12 - label.size(), ' ') + text + "\n";
}

std::string result_ending(const RunReport& report, const std::filesystem::path& folder) {
  std::string text;
  for (const auto& [stage, seconds] : report.timings)
    if (stage == "total") text += result_line("time", number(seconds) + " s");
  text += "files in " + folder.string() + ":\n";
  for (const auto& file : report.files) text += "  " + file + "\n";
  return text;
}

}  // namespace batten
