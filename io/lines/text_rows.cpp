// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/text_rows.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace fs = std::filesystem;

TextRows::TextRows(const fs::path& path) : path_(path) {
  text_ = read_input_file(path, "a file of points");
  if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"))
    throw InputError(path.string() + ":1:1: found UTF-16 text, expected UTF-8 or ASCII");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  replace_carriage_returns(text_);
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

double TextRows::number_in(std::string_view field, const std::string& expected,
                           bool decimal_comma) const {
  field = without_quotes(field);
  const size_t comma = decimal_comma ? field.find(',') : field.npos;
  if (comma != field.npos) {
    std::string with_point(field);
    with_point[comma] = '.';
    double value = 0;
    const char *first = with_point.data(), *last = first + with_point.size();
    const auto [end, error] = std::from_chars(first + with_point.starts_with('+'), last, value);
    if (error != std::errc() || end != last || !std::isfinite(value))
      fail(field.data(), "found " + quoted_excerpt(field) + ", expected " + expected);
    return value;
  }
  double value = 0;
  const char *first = field.data(), *last = first + field.size();
  // from_chars does not accept a leading plus
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

namespace {

/// Length of the double-quoted field with which a text begins, with its quotes; 0 if there is none.
size_t quoted_length(std::string_view text) {
  if (!text.starts_with('"')) return 0;
  for (size_t i = text.find('"', 1); i != text.npos; i = text.find('"', i + 2))
    if (i + 1 == text.size() || text[i + 1] != '"') return i + 1;
  return 0;
}

}  // namespace

std::string_view without_comment(std::string_view row) {
  bool starts_field = true;
  for (size_t i = 0; i < row.size(); ++i) {
    if (const size_t quoted = starts_field ? quoted_length(row.substr(i)) : 0; quoted > 0) {
      i += quoted - 1;
      starts_field = false;
      continue;
    }
    if (row[i] == '#' || (row[i] == '/' && i + 1 < row.size() && row[i + 1] == '/'))
      return trimmed(row.substr(0, i));
    starts_field = is_blank(row[i]) || row[i] == ',' || row[i] == ';';
  }
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

bool drop_empty_end(std::vector<std::string_view>& fields) {
  if (fields.size() < 2 || !fields.back().empty()) return false;
  fields.pop_back();
  return true;
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
    size_t first = start;
    while (first < row.size() && is_blank(row[first]) && row[first] != separator) ++first;
    const size_t quoted = quoted_length(row.substr(first));
    const size_t end = std::min(row.find(separator, first + quoted), row.size());
    fields.push_back(trimmed(row.substr(start, end - start)));
    start = end + 1;
  }
}

namespace {

using Fields = std::vector<std::string_view>;

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)); }
bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)); }

std::optional<double> number_of(std::string_view field) {
  double value = 0;
  if (field.starts_with('+')) field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
    return {};
  return value;
}

// True for a field of digits in which at most one character cannot occur in a number.
bool is_misspelt_number(std::string_view field) {
  if (std::none_of(field.begin(), field.end(), is_digit)) return false;
  return std::count_if(field.begin(), field.end(), [](char c) {
           return !is_digit(c) && std::string_view("+-.,eE").find(c) == std::string_view::npos;
         }) <= 1;
}

// The axis index 0, 1, 2 for x, y, z; -1 for other names.
int axis_of(std::string_view field) {
  const std::string name = lower_case(std::string(without_quotes(field)));
  if (name.starts_with("points:") && name.size() == 8) return name[7] - '0';
  if (name.empty() || name[0] < 'x' || name[0] > 'z') return -1;
  if (name.size() > 1 && (is_letter(name[1]) || is_digit(name[1]))) return -1;
  return name[0] - 'x';
}


Fields fields_of(std::string_view row, char separator) {
  Fields fields;
  if (separator == 0)
    split_fields(row, fields);
  else
    split_at(row, separator, fields);
  return fields;
}

}  // namespace

char separator_of(std::string_view row) {
  for (const char c : {';', '\t', ','})
    for (size_t i = 0; i < row.size(); i += std::max<size_t>(quoted_length(row.substr(i)), 1))
      if (row[i] == c) return c;
  return 0;
}

bool is_header(std::string_view row, bool first_row) {
  Fields fields;
  if (row.find('"') == row.npos)
    split_fields(row, fields);
  else
    fields = fields_of(row, separator_of(row));
  for (std::string_view& field : fields) field = without_quotes(field);
  std::erase_if(fields, [](std::string_view f) { return f.empty(); });
  const long numbers = std::count_if(fields.begin(), fields.end(), starts_like_number);
  const long texts = isize(fields) - numbers;
  // Empty corner of an offset table.
  const bool corner = fields_of(row, separator_of(row))[0].empty();
  if (texts == 0) return first_row && (corner || (fields.size() == 1 && is_digits(fields[0])));
  if (starts_like_number(fields[0]) &&
      (texts < numbers || (texts == numbers && separator_of(row) != 0)))
    return false;
  if (fields.size() > 1 && std::all_of(fields.begin(), fields.end(), is_misspelt_number))
    return false;
  const auto axis = [](std::string_view f) { return f.size() == 1 && axis_of(f) >= 0; };
  const bool axes = std::any_of(fields.begin(), fields.end(), axis);
  // The corner of an offset table may be such a letter: "x 0 1 2".
  return !axes || numbers == 0 || (axis(fields[0]) && texts == 1);
}

HeaderColumns parse_header_columns(std::string_view heading) {
  HeaderColumns columns;
  columns.separator = separator_of(heading);
  Fields names = fields_of(heading, columns.separator);
  drop_empty_end(names);
  columns.count = names.size();
  for (int i = 0; i < isize(names); ++i) {
    const std::string_view name = without_quotes(names[static_cast<size_t>(i)]);
    const int axis = axis_of(name);
    if (axis >= 0 && axis < 3 && columns.axes[static_cast<size_t>(axis)] < 0)
      columns.axes[static_cast<size_t>(axis)] = i;
    else if (name == "line" || name == "name" || name == "curve")
      columns.name = i;
  }
  return columns;
}

HeaderColumns header_columns(std::string_view heading, std::string_view row) {
  const HeaderColumns columns = parse_header_columns(heading);
  Fields values = fields_of(row, columns.separator);
  if (values.size() > columns.count) drop_empty_end(values);
  if (values.size() != columns.count) return {};
  for (const int axis : columns.axes)
    if (axis >= 0 && !starts_like_number(without_quotes(values[static_cast<size_t>(axis)])))
      return {};
  return columns;
}

std::string header_name(std::string_view heading) {
  return std::string(without_quotes(trimmed(heading)));
}

namespace {

bool names_waterlines(const std::string& word) {
  return word == "z" || word == "h" || word.starts_with("w") || word.starts_with("height");
}
bool names_stations(const std::string& word) {
  return word == "x" || word.starts_with("st") || word.starts_with("sec") ||
         word.starts_with("fr");
}

// A heading of a row or column of an offset table, such as "150", "WL 150" or "Station 3".
struct OffsetLabel {
  std::string word;  // in lower case; may be empty
  double position = 0;
};

std::optional<OffsetLabel> offset_label(std::string_view field, bool decimal_comma) {
  field = without_quotes(field);
  const size_t digits = field.find_first_of("+-0123456789");
  if (digits == field.npos) return {};
  const std::string_view word = trimmed(field.substr(0, digits));
  std::string number(field.substr(digits));
  if (const size_t comma = decimal_comma ? number.find(',') : number.npos; comma != number.npos)
    number[comma] = '.';
  const std::optional<double> position = number_of(number);
  const std::string name = lower_case(std::string(word));
  if (!position || !(name.empty() || names_waterlines(name) || names_stations(name))) return {};
  return OffsetLabel{name, *position};
}

// The first word of a text, in lower case.
std::string first_word(std::string_view text) {
  size_t length = 0;
  while (length < text.size() && is_letter(text[length])) ++length;
  return lower_case(std::string(text.substr(0, length)));
}

}  // namespace

std::optional<OffsetTable> offset_table(std::string_view heading, std::string_view row) {
  OffsetTable table;
  table.separator_ = separator_of(heading);
  table.decimal_commas_ = table.separator_ != ',' && table.separator_ != 0;
  Fields fields = fields_of(heading, table.separator_);
  drop_empty_end(fields);
  const Fields first = fields_of(row, table.separator_);
  if (fields.size() < 3 || first.size() < fields.size() || first.size() > fields.size() + 1)
    return {};
  const std::string_view corner = without_quotes(fields[0]);
  if (number_of(corner)) return {};
  const auto label_of_row = offset_label(first[0], table.decimal_commas_);
  if (!label_of_row) return {};
  table.rows_are_waterlines_ =
      names_waterlines(first_word(corner)) || names_waterlines(label_of_row->word);
  for (size_t i = 1; i < fields.size(); ++i) {
    const auto label = offset_label(fields[i], table.decimal_commas_);
    if (!label) return {};
    if (names_stations(label->word)) table.rows_are_waterlines_ = true;
    table.positions_.push_back(label->position);
  }
  const auto& p = table.positions_;
  const bool monotone =
      std::adjacent_find(p.begin(), p.end(), std::greater_equal<>()) == p.end() ||
      std::adjacent_find(p.begin(), p.end(), std::less_equal<>()) == p.end();
  if (!monotone) return {};
  return table;
}

std::vector<NamedPoints> OffsetTable::read(TextRows& rows, double scale) const {
  std::map<double, NamedPoints> stations;
  const size_t columns = positions_.size() + 1;
  Fields fields;
  do {
    const std::string_view row = without_comment(rows.row());
    if (row.find_first_not_of(" \t,;") == row.npos) continue;
    fields = fields_of(row, separator_);
    if (fields.size() == columns + 1) drop_empty_end(fields);
    if (fields.size() != columns)
      rows.fail(row.data(), "found " + format_count(isize(fields), "column") + ", expected " +
                                std::to_string(columns) + " as in the first row");
    const auto label = offset_label(fields[0], decimal_commas_);
    const double along =
        label ? label->position : rows.number_in(fields[0], "a number", decimal_commas_);
    for (size_t i = 1; i < columns; ++i) {
      const std::string_view field = without_quotes(fields[i]);
      if (field.empty() || field == "-") continue;
      const double breadth =
          rows.number_in(field, "a half-breadth or an empty field", decimal_commas_);
      const auto [x, z] = rows_are_waterlines_ ? std::pair(positions_[i - 1], along)
                                               : std::pair(along, positions_[i - 1]);
      NamedPoints& line = stations[x];
      if (line.points.empty()) line.first_line = rows.line();
      line.points.push_back(scale * Vec3(x, breadth, z));
    }
  } while (rows.next());
  std::vector<NamedPoints> lines;
  for (auto& [along, line] : stations) {
    if (line.points.size() < 2) continue;
    std::sort(line.points.begin(), line.points.end(),
              [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
    line.name = "station " + format_number(along);
    if (lines.empty())
      line.format_note = std::string("from an offset table, whose rows are ") +
                         (rows_are_waterlines_ ? "waterlines" : "stations");
    lines.push_back(std::move(line));
  }
  return lines;
}

void join_lednicer(std::vector<NamedPoints>& lines, double scale) {
  if (lines.empty() || lines.size() > 3 || lines[0].points.empty()) return;
  const Vec3 counts = lines[0].points[0] / scale;
  const double upper = std::round(counts.x()), lower = std::round(counts.y());
  if (upper < 2 || lower < 2 || std::abs(counts.x() - upper) > 1e-6 ||
      std::abs(counts.y() - lower) > 1e-6)
    return;
  std::vector<Vec3> points;
  for (const NamedPoints& line : lines)
    points.insert(points.end(), line.points.begin(), line.points.end());
  if (static_cast<double>(points.size()) != 1 + upper + lower) return;
  const auto side = points.begin() + 1 + static_cast<long>(upper);
  const double chord = (*(side - 1) - points[1]).norm();
  // Both sides must begin at the leading edge.
  if (!((*side - points[1]).norm() < 0.05 * chord)) return;
  std::vector<Vec3> around(points.begin() + 1, side);
  std::reverse(around.begin(), around.end());
  const bool same = (*side - points[1]).norm() < 1e-9 * chord;
  around.insert(around.end(), side + (same ? 1 : 0), points.end());
  const NamedPoints& first = lines.size() > 1 ? lines[1] : lines[0];
  const std::string title = lines[0].format_note;
  lines = {NamedPoints{lines[0].name, std::move(around), first.first_line,
                       "both sides of an airfoil, joined at the leading edge" +
                           (title.empty() ? "" : ", " + title)}};
}

std::string_view without_quotes(std::string_view field) {
  field = trimmed(field);
  if (field.size() > 1 && field.front() == '"' && field.back() == '"')
    field = trimmed(field.substr(1, field.size() - 2));
  return field;
}

std::string unquoted(std::string_view field) {
  field = trimmed(field);
  if (field.empty() || quoted_length(field) != field.size())
    return std::string(without_quotes(field));
  std::string text;
  for (size_t i = 1; i + 1 < field.size(); ++i) {
    text += field[i];
    i += field[i] == '"';
  }
  return text;
}

bool is_digits(std::string_view field) {
  return !field.empty() && std::all_of(field.begin(), field.end(), is_digit);
}

}  // namespace batten
