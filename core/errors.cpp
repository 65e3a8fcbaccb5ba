// SPDX-License-Identifier: MPL-2.0
#include "batten/core/errors.h"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace batten {
namespace {

std::string describe(const std::vector<ConflictError::Conflict>& conflicts) {
  std::string text = "constraints contradict each other:";
  for (const auto& c : conflicts) {
    text += "\n  ";
    for (size_t i = 0; i < c.names.size(); ++i)
      text += (i == 0 ? "'" : i + 1 == c.names.size() ? "' and '" : "', '") + c.names[i];
    text += c.names.size() > 1 ? "' differ by " : "' is violated by ";
    text += format_number(c.amount) + c.unit;
  }
  return text;
}

}  // namespace

ConflictError::ConflictError(std::vector<Conflict> conflicts, const std::string& where)
    : Error(where + describe(conflicts)), conflicts_(std::move(conflicts)) {}

std::string format_number(double value) {
  // std::to_chars does not depend on the locale of the process.
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr};
}

std::string closest_match(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  size_t best_distance = std::string::npos;
  for (const auto& candidate : words) {
    std::vector<size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 1; i <= word.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i;
      for (size_t j = 1; j <= candidate.size(); ++j) {
        const size_t substituted = diagonal + (word[i - 1] != candidate[j - 1]);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  const size_t limit = std::max<size_t>(1, (word.size() + 1) / 3);
  return best_distance <= limit ? best : "";
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& words) {
  const std::string closest = closest_match(word, words);
  return closest.empty() ? "" : "; did you mean '" + closest + "'?";
}

}  // namespace batten
