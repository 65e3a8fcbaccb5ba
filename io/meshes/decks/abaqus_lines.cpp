// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/abaqus_lines.h"

namespace batten {

std::string_view unquoted(std::string_view text) {
  const bool quotes = text.size() > 1 && text.front() == '"' && text.back() == '"';
  return quotes ? text.substr(1, text.size() - 2) : text;
}

std::vector<std::string_view> comma_values(std::string_view line) {
  std::vector<std::string_view> values;
  for (;;) {
    const size_t comma = line.find(',');
    values.push_back(unquoted(trimmed(line.substr(0, comma))));
    if (comma == line.npos) return values;
    line.remove_prefix(comma + 1);
  }
}

std::vector<std::string_view> local_names(std::string_view name) {
  std::vector<std::string_view> names{name};
  for (size_t dot = name.find('.'); dot != name.npos; dot = name.find('.', dot + 1))
    names.push_back(name.substr(dot + 1));
  return names;
}

/// Reads the next line that is not a comment, following *INCLUDE.
bool AbaqusLines::next(std::string_view& line) {
  while (file_.next(line)) {
    if (line.starts_with("**")) continue;
    if (!line.starts_with('*') || upper(trimmed(line.substr(1, line.find(',') - 1))) != "INCLUDE")
      return true;
    const std::string_view at = line;
    line_ = line;
    file_.include(std::string(read_keyword().value("INPUT")), at);
  }
  line = {};
  return false;
}

bool AbaqusLines::next_data() {
  // The keyword that ended the data lines is kept for next_keyword().
  if (line_.starts_with('*')) return false;
  while (next(line_)) {
    if (line_.starts_with('*')) return false;
    if (!trimmed(line_).empty()) return true;
  }
  return false;
}

std::optional<Keyword> AbaqusLines::next_keyword() {
  while (!line_.starts_with('*'))
    if (!next(line_)) return {};
  return read_keyword();
}

Keyword AbaqusLines::read_keyword() {
  Keyword keyword;
  keyword.line = line_;
  std::string_view rest = line_.substr(1);
  bool first = true;
  for (;;) {
    const size_t comma = rest.find(',');
    const std::string_view part = trimmed(rest.substr(0, comma));
    const size_t equals = part.find('=');
    if (first) {
      std::string_view name_tokens = part;
      for (auto token = next_token(name_tokens); !token.empty(); token = next_token(name_tokens))
        keyword.name += (keyword.name.empty() ? "" : " ") + upper(token);
    } else if (!part.empty()) {
      const std::string_view value = equals == part.npos ? "" : trimmed(part.substr(equals + 1));
      keyword.parameters[upper(trimmed(part.substr(0, equals)))] = unquoted(value);
    }
    first = false;
    if (comma == rest.npos) break;
    rest.remove_prefix(comma + 1);
    if (!trimmed(rest).empty()) continue;
    if (!file_.next_in_file(line_)) break;
    rest = line_;
  }
  line_ = {};
  return keyword;
}

void AbaqusLines::follow_input(const Keyword& keyword) {
  if (keyword.has("INPUT")) file_.include(std::string(keyword.value("INPUT")), keyword.line);
}

}  // namespace batten
