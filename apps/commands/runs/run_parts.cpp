#include "batten/apps/commands/runs/run_parts.h"

#include <cmath>
#include <cstdlib>

namespace batten {

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

std::string result_line(const std::string& label, const std::string& text) {
  return "  " + label + std::string(12 - label.size(), ' ') + text + "\n";
}

}  // namespace batten
