#include "batten/io/meshes/nastran_cards.h"

#include "batten/core/errors.h"

namespace batten {

CardLine::CardLine(std::string_view line) : data(line.substr(0, line.find('$'))), cells(data) {
  std::string_view first = cells.value(0, 0, 8);
  // A name may run on past its columns: BEGIN BULK.
  large = first.ends_with('*') || first.starts_with('*');
  if (first.ends_with('*') && first.size() > 1) first.remove_suffix(1);
  name = first;
}

bool NastranCards::next(std::string_view& line) {
  while (file_.next(line))
    if (!follow(line)) return true;
  return false;
}

/// The name may run over several lines, in which blanks at both ends do not count.
bool NastranCards::follow(std::string_view line) {
  std::string_view rest = trimmed(line);
  if (rest.size() < 8 || upper(rest.substr(0, 7)) != "INCLUDE") return false;
  rest.remove_prefix(7);
  if (!is_blank(rest[0]) && rest[0] != '\'' && rest[0] != '"') return false;
  rest = trimmed(rest);
  std::string name;
  if (rest.starts_with('\'') || rest.starts_with('"')) {
    const char quote = rest[0];
    rest.remove_prefix(1);
    while (rest.find(quote) == rest.npos) {
      name += trimmed(rest);
      if (!file_.next_in_file(rest))
        file_.fail(line,
                   "found " + quoted_excerpt(line) + " without its second quote, expected one");
    }
    name += trimmed(rest.substr(0, rest.find(quote)));
  } else {
    name = trimmed(rest.substr(0, rest.find('$')));
  }
  file_.include(name, line);
  return true;
}

bool NastranCards::next_line(std::optional<CardLine>& card) {
  const size_t start = file_.position();
  std::string_view line;
  while (file_.next_in_file(line)) {
    if (line.empty() || line[0] == '$' || trimmed(line).empty()) continue;
    card.emplace(line);
    if (card->continues()) return true;
    break;
  }
  file_.seek(start);
  return false;
}

std::vector<std::string_view> NastranCards::values_of(const CardLine& card) {
  std::vector<std::string_view> values;
  std::optional<CardLine> line(card);
  do {
    for (int i = 1; i <= line->count(); ++i) values.push_back(line->value(i));
  } while (next_line(line));
  return values;
}

std::string_view read_ranges(std::span<const std::string_view> values,
                             std::vector<LabelRange>& ranges) {
  bool thru = false;
  for (const std::string_view value : values) {
    long label = 0;
    if (value.empty()) continue;
    if (upper(value) == "THRU" && !ranges.empty()) {
      thru = true;
    } else if (!parse_integer(value, label)) {
      return value;
    } else if (thru) {
      ranges.back().last = label;
      thru = false;
    } else {
      ranges.push_back({label, label});
    }
  }
  return {};
}

}  // namespace batten
