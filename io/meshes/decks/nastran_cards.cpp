// SPDX-License-Identifier: MPL-2.0
#include "batten/io/meshes/decks/nastran_cards.h"

#include <algorithm>

namespace batten {

CardLine::CardLine(std::string_view line) : data(line.substr(0, line.find('$'))), cells(data) {
  std::string_view first = cells.value(0, 0, 8);
  // The name may extend beyond its columns: BEGIN BULK.
  large = first.ends_with('*') || first.starts_with('*');
  if (first.ends_with('*') && first.size() > 1) first.remove_suffix(1);
  name = first;
  count_ = large ? 4 : 8;
  // A free line may go on beyond the continuation field, which holds no number.
  const int last = cells.count() - 1;
  double number = 0;
  if (cells.free() && last > count_)
    count_ = parse_real(cells.value(last, 0, 0), number) || last > count_ + 1 ? last : count_;
}

bool NastranCards::next(std::string_view& line) {
  while (file_.next(line))
    if (!follow(line)) return true;
  return false;
}

/// Follows INCLUDE. A file name may span several lines; blanks at both ends of each are ignored.
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

BulkCard NastranCards::whole(const CardLine& card) {
  BulkCard result;
  std::optional<CardLine> line(card);
  do {
    for (int i = 1; i <= line->count(); ++i) result.values.push_back(line->value(i));
    result.lines.push_back(*line);
  } while (next_line(line));
  return result;
}

std::array<Field, 3> BulkCard::fields(const MeshSourceText& file, int first) const {
  std::array<Field, 3> result;
  int begin = 0;  // first value of the line
  for (const CardLine& line : lines) {
    const int low = std::max(first, begin), high = std::min(first + 3, begin + line.count());
    if (low < high)
      line.fields(file, 1 + low - begin,
                  std::span(result).subspan(static_cast<size_t>(low - first),
                                            static_cast<size_t>(high - low)));
    begin += line.count();
  }
  return result;
}

Vec3 BulkCard::vector(const MeshSourceText& file, int first) const {
  return {file.real(at(first), true), file.real(at(first + 1), true),
          file.real(at(first + 2), true)};
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
