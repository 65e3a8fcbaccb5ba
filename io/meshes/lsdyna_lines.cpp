#include "batten/io/meshes/lsdyna_lines.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/meshes/deck_mesh_builder.h"

namespace batten {
namespace {

constexpr DynaWidths kStandard;
constexpr DynaWidths kI10{10, 16, 10, FieldKind::Dyna16, FieldKind::DynaFree16};
constexpr DynaWidths kLong{20, 20, 20, FieldKind::Dyna20, FieldKind::DynaFree20};

}  // namespace

std::optional<std::set<std::string>> options_after(const std::string& name,
                                                   const std::string& first) {
  if (!name.starts_with(first)) return {};
  std::set<std::string> options;
  std::string_view rest = std::string_view(name).substr(first.size());
  if (!rest.empty() && rest[0] != '_') return {};
  while (!rest.empty()) {
    rest.remove_prefix(1);
    options.emplace(rest.substr(0, rest.find('_')));
    rest.remove_prefix(std::min(rest.find('_'), rest.size()));
  }
  return options;
}

void DynaLines::leave_file() {
  file_.leave_file();
  widths_ = outer_.back();
  outer_.pop_back();
}

/// The next line that is not a comment; empty at the end.
bool DynaLines::next(std::string_view& line) {
  for (;;) {
    while (file_.next_in_file(line))
      if (!line.starts_with('$')) return true;
    line = {};
    if (file_.depth() == 0) return false;
    leave_file();
  }
}

bool DynaLines::next_card() {
  // The keyword that ended the cards stays.
  return !line_.starts_with('*') && next(line_) && !line_.starts_with('*');
}

bool DynaLines::next_record() {
  while (next_card())
    if (!trimmed(line_).empty()) return true;
  return false;
}

std::optional<DynaKeyword> DynaLines::next_keyword() {
  for (;;) {
    while (!line_.starts_with('*'))
      if (!next(line_)) return {};
    const DynaKeyword keyword = read_keyword();
    line_ = {};
    if (keyword.name == "END") {
      if (file_.depth() > 0) {
        leave_file();
        continue;
      }
      ended_ = true;
      return {};
    }
    if (!include(keyword)) return keyword;
  }
}

DynaKeyword DynaLines::read_keyword() {
  std::string_view rest = line_.substr(1);
  DynaKeyword keyword{upper(next_word(rest)), widths_, line_};
  keyword.name = keyword.name.substr(0, keyword.name.find(','));
  char suffix = keyword.name.empty() ? ' ' : keyword.name.back();
  if (suffix == '+' || suffix == '-' || suffix == '%')
    keyword.name.pop_back();
  else
    suffix = trimmed(rest).size() == 1 ? trimmed(rest)[0] : ' ';
  if (suffix == '+') keyword.widths = kLong;
  if (suffix == '-') keyword.widths = kStandard;
  if (suffix == '%') keyword.widths = kI10;
  if (keyword.name == "KEYWORD") read_format(keyword, rest);
  return keyword;
}

void DynaLines::read_format(const DynaKeyword& keyword, std::string_view options) {
  // LONG=S reads standard cards.
  std::string text = upper(options);
  std::erase_if(text, is_blank);
  DynaWidths widths = widths_;
  if (text.find("I10=Y") != text.npos) widths = kI10;
  if (text.find("LONG=Y") != text.npos || text.find("LONG=K") != text.npos) widths = kLong;
  // LS-DYNA goes by what *INCLUDE says, others by what the file itself says.
  if (file_.depth() > 0 && widths != widths_)
    file_.fail(keyword.line, "found " + quoted_excerpt(keyword.line) +
                                 " in a file that is included in another format, expected both to "
                                 "be the same (*INCLUDE +, - or %)");
  widths_ = widths;
}

/// The cards of a keyword up to the next one, or to the end of the current file.
std::vector<std::string_view> DynaLines::rest_of_block() {
  std::vector<std::string_view> cards;
  std::string_view line;
  for (size_t start = file_.position(); file_.next_in_file(line); start = file_.position()) {
    if (line.starts_with('*')) {
      file_.seek(start);
      break;
    }
    if (!line.starts_with('$')) cards.push_back(line);
  }
  return cards;
}

/// Names of files, of which a long one goes on in the next card after " +".
std::vector<std::pair<std::string, std::string_view>> DynaLines::names(bool transformed,
                                                                       const DynaKeyword& keyword) {
  const std::vector<std::string_view> cards = rest_of_block();
  std::vector<std::pair<std::string, std::string_view>> found;
  bool goes_on = false;
  for (size_t i = 0; i < cards.size(); ++i) {
    std::string_view text = trimmed(cards[i]);
    if (text.empty()) continue;
    if (!goes_on) found.push_back({"", cards[i]});
    goes_on = text.ends_with(" +");
    if (goes_on) text = trimmed(text.substr(0, text.size() - 2));
    found.back().first += text;
    if (goes_on || !transformed) continue;
    require_identity(std::span(cards).subspan(i + 1), keyword);
    break;
  }
  return found;
}

/// Offsets of numbers, factors of units and a transformation: all of them must change nothing.
void DynaLines::require_identity(std::span<const std::string_view> cards,
                                 const DynaKeyword& keyword) const {
  constexpr size_t kFactors = 2, kTransformation = 3;
  for (size_t i = 0; i < cards.size() && i <= kTransformation; ++i) {
    const DeckLine line(cards[i]);
    // Behind the factors stands what is printed; prefixes and suffixes of names change no node.
    const int count = i == 0 ? 7 : i == kFactors ? 4 : 1;
    for (int k = 0; k < count; ++k) {
      const std::string_view value = line.value(k, k * keyword.widths.card, keyword.widths.card);
      double number = 0;
      if (value.empty()) continue;
      const bool same =
          (i == kFactors && value == "0") ||
          (parse_real(value, number) && (number == 0 || (i == kFactors && number == 1)));
      if (!same)
        file_.fail(value, "found " + quoted_excerpt(value) + " of *" + keyword.name +
                              ", expected a file that is included as it is");
    }
  }
}

bool DynaLines::include(const DynaKeyword& keyword) {
  if (!keyword.name.starts_with("INCLUDE")) return false;
  if (keyword.name == "INCLUDE_PATH" || keyword.name == "INCLUDE_PATH_RELATIVE") {
    for (const auto& [folder, line] : names(false, keyword)) folders_.push_back(folder);
    return true;
  }
  const bool transformed = keyword.name == "INCLUDE_TRANSFORM";
  if (keyword.name != "INCLUDE" && !transformed) {
    ++skipped_includes_;
    return false;
  }
  const auto found = names(transformed, keyword);
  // Each is read before those behind it: the last one waits longest.
  for (auto name = found.rbegin(); name != found.rend(); ++name) {
    file_.include(name->first, name->second, folders_);
    outer_.push_back(widths_);
    widths_ = keyword.widths;
  }
  return true;
}

}  // namespace batten
