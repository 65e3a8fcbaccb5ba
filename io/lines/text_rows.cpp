#include "batten/io/lines/text_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace fs = std::filesystem;

TextRows::TextRows(const fs::path& path) : path_(path) {
  text_ = read_input_file(path, "a file of points");
  if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"))
    throw InputError(path.string() + ":1:1: found UTF-16 text, expected UTF-8 or ASCII");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  if (std::all_of(text_.begin(), text_.end(), [](char c) { return is_blank(c) || c == '\n'; }))
    throw InputError(path.string() + ":1:1: found an empty file, expected points");
}

bool TextRows::next() {
  const size_t begin = line_ > 0 ? end_ + 1 : 0;
  if (begin >= text_.size()) return false;
  begin_ = begin;
  end_ = std::min(text_.find('\n', begin_), text_.size());
  ++line_;
  return true;
}

void TextRows::fail(const char* where, const std::string& message) const {
  throw InputError(path_.string() + ":" + std::to_string(line_) + ":" +
                   std::to_string(where - (text_.data() + begin_) + 1) + ": " + message);
}

double TextRows::number_in(std::string_view field, const std::string& expected) const {
  double value = 0;
  const char *first = field.data(), *last = first + field.size();
  // from_chars knows no leading plus.
  const bool plus = field.size() > 1 && field[0] == '+' && field[1] != '-' && field[1] != '+';
  const auto [end, error] = std::from_chars(first + plus, last, value);
  if (error == std::errc::result_out_of_range)
    fail(first, "found " + quoted_excerpt(field) + ", expected a number between 1e-307 and 1e308");
  if (error != std::errc() || end != last)
    fail(first, "found " + quoted_excerpt(field) + ", expected " + expected);
  if (!std::isfinite(value))
    fail(first, "found " + quoted_excerpt(field) + ", expected a finite number");
  return value;
}

std::string_view without_comment(std::string_view row) {
  for (size_t i = 0; i < row.size(); ++i)
    if (row[i] == '#' || (row[i] == '/' && i + 1 < row.size() && row[i + 1] == '/'))
      return trimmed(row.substr(0, i));
  return trimmed(row);
}

bool starts_like_number(std::string_view field) {
  double value;
  if (field.starts_with('+')) field.remove_prefix(1);
  return std::from_chars(field.data(), field.data() + field.size(), value).ec !=
         std::errc::invalid_argument;
}

void split_fields(std::string_view row, std::vector<std::string_view>& fields) {
  fields.clear();
  size_t i = 0;
  const auto skip_blanks = [&] {
    while (i < row.size() && is_blank(row[i])) ++i;
  };
  const auto separator = [&] { return i < row.size() && (row[i] == ',' || row[i] == ';'); };
  for (;;) {
    const size_t start = i;
    while (i < row.size() && !is_blank(row[i]) && !separator()) ++i;
    fields.push_back(row.substr(start, i - start));
    skip_blanks();
    if (i == row.size()) return;
    if (!separator()) continue;
    ++i;
    skip_blanks();
    if (i == row.size()) {
      fields.push_back(row.substr(i));  // nothing after the last separator
      return;
    }
  }
}

void split_at(std::string_view row, char separator, std::vector<std::string_view>& fields) {
  if (separator == ' ') {
    fields.clear();
    for (size_t i = 0; i < row.size();) {
      while (i < row.size() && is_blank(row[i])) ++i;
      const size_t start = i;
      while (i < row.size() && !is_blank(row[i])) ++i;
      if (i > start) fields.push_back(row.substr(start, i - start));
    }
    return;
  }
  fields.clear();
  for (size_t start = 0; start <= row.size();) {
    const size_t end = std::min(row.find(separator, start), row.size());
    fields.push_back(trimmed(row.substr(start, end - start)));
    start = end + 1;
  }
}

}  // namespace batten
