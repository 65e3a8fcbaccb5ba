#include "batten/io/lines/point_lines.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

std::string plural(long count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

bool blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

/// The text of one file, gone through row by row.
class Rows {
 public:
  Rows(const fs::path& path) : path_(path) {
    std::error_code error;
    if (!fs::exists(path, error)) throw InputError(path.string() + ": this file does not exist");
    if (fs::is_directory(path, error))
      throw InputError(path.string() + ": found a folder, expected a file");
    std::ifstream in(path, std::ios::binary);
    if (in) text_.assign(std::istreambuf_iterator<char>(in), {});
    if (!in) throw InputError(path.string() + ": this file cannot be read");
    if (text_.starts_with("\xFF\xFE") || text_.starts_with("\xFE\xFF"))
      throw InputError(path.string() + ":1:1: found UTF-16 text, expected UTF-8 or ASCII");
    if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
    if (std::all_of(text_.begin(), text_.end(), [](char c) { return blank(c) || c == '\n'; }))
      throw InputError(path.string() + ":1:1: found an empty file, expected points");
  }

  /// Moves to the next row; false at the end.
  bool next() {
    const size_t begin = line_ > 0 ? end_ + 1 : 0;
    if (begin >= text_.size()) return false;
    begin_ = begin;
    end_ = std::min(text_.find('\n', begin_), text_.size());
    ++line_;
    return true;
  }
  /// The row without its line end; comments are still in it.
  std::string_view row() const { return std::string_view(text_).substr(begin_, end_ - begin_); }
  int line() const { return line_; }
  const fs::path& path() const { return path_; }

  /// `where` points into the text.
  [[noreturn]] void fail(const char* where, const std::string& message) const {
    throw InputError(path_.string() + ":" + std::to_string(line_) + ":" +
                     std::to_string(where - (text_.data() + begin_) + 1) + ": " + message);
  }

  /// The number that `field` is.
  double number_in(std::string_view field, const std::string& expected) const {
    double value = 0;
    const char *first = field.data(), *last = first + field.size();
    // from_chars knows no leading plus.
    const bool plus = field.size() > 1 && field[0] == '+' && field[1] != '-' && field[1] != '+';
    const auto [end, error] = std::from_chars(first + plus, last, value);
    if (error == std::errc::result_out_of_range)
      fail(first, "found " + in_quotes(field) + ", expected a number between 1e-307 and 1e308");
    if (error != std::errc() || end != last)
      fail(first, "found " + in_quotes(field) + ", expected " + expected);
    if (!std::isfinite(value))
      fail(first, "found " + in_quotes(field) + ", expected a finite number");
    return value;
  }

 private:
  fs::path path_;
  std::string text_;
  size_t begin_ = 0, end_ = 0;
  int line_ = 0;
};

/// Cut off '#' and '//' comments and blanks at both ends.
std::string_view without_comment(std::string_view row) {
  for (size_t i = 0; i < row.size(); ++i)
    if (row[i] == '#' || (row[i] == '/' && i + 1 < row.size() && row[i + 1] == '/')) {
      row = row.substr(0, i);
      break;
    }
  while (!row.empty() && blank(row.back())) row.remove_suffix(1);
  while (!row.empty() && blank(row.front())) row.remove_prefix(1);
  return row;
}

/// Fields of a row: blanks, with at most one comma or semicolon among them, separate.
void split_table_row(std::string_view row, std::vector<std::string_view>& fields) {
  fields.clear();
  size_t i = 0;
  const auto skip_blanks = [&] {
    while (i < row.size() && blank(row[i])) ++i;
  };
  const auto separator = [&] { return i < row.size() && (row[i] == ',' || row[i] == ';'); };
  for (;;) {
    const size_t start = i;
    while (i < row.size() && !blank(row[i]) && !separator()) ++i;
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

bool starts_like_number(std::string_view field) {
  double value;
  if (field.starts_with('+')) field.remove_prefix(1);
  return std::from_chars(field.data(), field.data() + field.size(), value).ec !=
         std::errc::invalid_argument;
}

std::vector<NamedPoints> read_table(Rows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<std::string_view> fields;
  bool first_row = true, new_line = true;
  size_t columns = 0;
  int columns_line = 0;
  const auto check_length = [&] {
    if (!lines.empty() && lines.back().points.size() < 2)
      throw InputError(rows.path().string() + ":" + std::to_string(lines.back().first_line) +
                       ":1: found a line of " +
                       plural(static_cast<long>(lines.back().points.size()), "point") +
                       ", expected 2 or more");
  };
  while (rows.next()) {
    const std::string_view row = without_comment(rows.row());
    if (row.find_first_not_of(" \t,;") == std::string_view::npos) {
      // A row with nothing but a comment does not end a line.
      if (rows.row().find_first_of("#/") == std::string_view::npos) new_line = true;
      continue;
    }
    split_table_row(row, fields);
    const bool first = std::exchange(first_row, false);
    if (fields.size() == 2 && fields[0] == "CURVE") {
      check_length();
      lines.push_back({"curve " + std::string(fields[1]), {}, rows.line()});
      new_line = false;
      continue;
    }
    if (first && std::none_of(fields.begin(), fields.end(), starts_like_number)) continue;
    if (columns == 0 && (fields.size() == 2 || fields.size() == 3)) {
      columns = fields.size();
      columns_line = rows.line();
    }
    Vec3 point = Vec3::Zero();
    for (size_t i = 0; i < fields.size(); ++i) {
      if (fields[i].empty())
        rows.fail(fields[i].data(),
                  "found an empty column " + std::to_string(i + 1) + ", expected a number");
      const double value =
          rows.number_in(fields[i], first ? "a number (a header row has words only)" : "a number");
      if (i < 3) point[static_cast<long>(i)] = scale * value;
    }
    if (fields.size() != columns) {
      const std::string expected =
          columns ? std::to_string(columns) + " as in line " + std::to_string(columns_line)
                  : std::string("2 or 3 (x, y, z)");
      const bool commas = row.find(';') != row.npos && row.find(',') != row.npos;
      rows.fail(row.data(), "found " + plural(static_cast<long>(fields.size()), "column") +
                                ", expected " + expected +
                                (commas ? "; numbers are written with a decimal point" : ""));
    }
    if (std::exchange(new_line, false)) {
      check_length();
      lines.push_back({"", {}, rows.line()});
    }
    lines.back().points.push_back(point);
  }
  check_length();
  return lines;
}

/// Words of an OBJ record, which goes on in the next row after a backslash.
class ObjWords {
 public:
  explicit ObjWords(Rows& rows) : rows_(rows), rest_(without_comment(rows.row())) {}
  /// Empty at the end of the record.
  std::string_view next() {
    for (;;) {
      while (!rest_.empty() && blank(rest_.front())) rest_.remove_prefix(1);
      if (rest_ != "\\" || !rows_.next()) break;
      rest_ = without_comment(rows_.row());
    }
    size_t length = 0;
    while (length < rest_.size() && !blank(rest_[length]) && rest_.substr(length) != "\\") ++length;
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return word;
  }
  std::string_view rest() {
    while (!rest_.empty() && blank(rest_.front())) rest_.remove_prefix(1);
    return rest_;
  }

 private:
  Rows& rows_;
  std::string_view rest_;
};

std::vector<NamedPoints> read_obj(Rows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<Vec3> vertices;
  std::string name;
  while (rows.next()) {
    const int line = rows.line();
    ObjWords words(rows);
    const std::string_view record = words.next();
    const auto end_of_row = [&] { return rows.row().data() + rows.row().size(); };
    if (record == "o" || record == "g") {
      name = words.rest();
    } else if (record == "v") {
      Vec3 point;
      for (int i = 0; i < 3; ++i) {
        const std::string_view word = words.next();
        if (word.empty())
          rows.fail(end_of_row(), "found " + plural(i, "coordinate") + ", expected 3 (v x y z)");
        point[i] = scale * rows.number_in(word, "a number");
      }
      vertices.push_back(point);
    } else if (record == "l") {
      NamedPoints result{name, {}, line};
      const long count = static_cast<long>(vertices.size());
      for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        // "vertex/texture": the first number is meant.
        const std::string_view digits = word.substr(0, word.find('/'));
        long index = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), index);
        if (digits.empty() || end != digits.data() + digits.size() || error != std::errc())
          rows.fail(word.data(), "found " + in_quotes(word) + ", expected a vertex number");
        const long vertex = index < 0 ? count + index : index - 1;
        if (index == 0 || vertex < 0 || vertex >= count)
          rows.fail(word.data(), "found vertex number " + std::to_string(index) + ", expected " +
                                     (count ? "1 to " + std::to_string(count) + " or -1 to -" +
                                                  std::to_string(count)
                                            : std::string("vertices (v records) before it")));
        result.points.push_back(vertices[vertex]);
      }
      if (result.points.size() < 2)
        rows.fail(end_of_row(), "found a line of " +
                                    plural(static_cast<long>(result.points.size()), "point") +
                                    ", expected 2 or more");
      lines.push_back(std::move(result));
    }
  }
  if (!vertices.empty() && lines.empty())
    throw InputError(rows.path().string() + ": found " +
                     plural(static_cast<long>(vertices.size()), "vertex record") +
                     " but no line, expected records 'l 1 2 3 …'");
  return lines;
}

/// The count of a row "v N".
long announced_points(const Rows& rows, std::string_view row) {
  std::vector<std::string_view> words;
  split_table_row(row, words);
  if (words[0] != "v")
    rows.fail(words[0].data(),
              "found " + in_quotes(words[0]) + ", expected 'v N' before the N points of a line");
  if (words.size() != 2)
    rows.fail(words[0].data(), "found " + plural(static_cast<long>(words.size()) - 1, "word") +
                                   " after 'v', expected the number of points");
  long count = 0;
  const char *first = words[1].data(), *last = first + words[1].size();
  const auto [end, error] = std::from_chars(first, last, count);
  if (error != std::errc() || end != last || count < 1)
    rows.fail(first, "found " + in_quotes(words[1]) + ", expected a number of points from 1");
  return count;
}

std::vector<NamedPoints> read_curves(Rows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<std::string_view> fields;
  long missing = 0;
  const auto promised = [&] {
    const auto& line = lines.back();
    return plural(static_cast<long>(line.points.size()), "point") + ", expected " +
           std::to_string(missing + static_cast<long>(line.points.size())) + " as line " +
           std::to_string(line.first_line) + " says";
  };
  while (rows.next()) {
    const std::string_view row = without_comment(rows.row());
    if (row.empty()) continue;
    if (missing == 0) {
      missing = announced_points(rows, row);
      lines.push_back({"", {}, rows.line()});
      continue;
    }
    split_table_row(row, fields);
    if (fields[0] == "v") rows.fail(row.data(), "found the next line after " + promised());
    if (fields.size() != 3)
      rows.fail(row.data(), "found " + plural(static_cast<long>(fields.size()), "number") +
                                ", expected 3 (x y z)");
    Vec3 point;
    for (int i = 0; i < 3; ++i) point[i] = scale * rows.number_in(fields[i], "a number");
    lines.back().points.push_back(point);
    --missing;
  }
  if (missing > 0)
    throw InputError(rows.path().string() + ":" + std::to_string(rows.line()) +
                     ":1: found the end of the file after " + promised());
  return lines;
}

void name_lines(std::vector<NamedPoints>& lines, const std::string& file) {
  std::map<std::string, int> count, used;
  std::set<std::string> taken;
  for (auto& line : lines) {
    if (line.name.empty()) line.name = file;
    ++count[line.name];
  }
  for (const auto& [name, n] : count)
    if (n == 1) taken.insert(name);
  for (auto& line : lines) {
    if (count[line.name] == 1) continue;
    std::string name;
    do name = line.name + "_" + std::to_string(++used[line.name]);
    while (!taken.insert(name).second);
    line.name = name;
  }
}

}  // namespace

std::vector<NamedPoints> read_point_lines(const fs::path& path, double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw InputError(path.string() + ": found a unit factor of " + number(scale) +
                     ", expected a number above 0");
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const std::vector<std::string> tables{".csv", ".txt", ".xyz", ".dat"};
  const bool obj = extension == ".obj", curves = extension == ".curves";
  if (!obj && !curves && std::find(tables.begin(), tables.end(), extension) == tables.end())
    throw InputError(path.string() + ": found " +
                     (extension.empty() ? "no extension" : "the extension '" + extension + "'") +
                     ", expected .csv, .txt, .xyz, .dat, .obj or .curves");
  Rows rows(path);
  std::vector<NamedPoints> lines = obj      ? read_obj(rows, scale)
                                   : curves ? read_curves(rows, scale)
                                            : read_table(rows, scale);
  if (lines.empty()) throw InputError(path.string() + ":1:1: found no points, expected some");
  name_lines(lines, path.stem().string());
  for (const auto& line : lines)
    for (const Vec3& p : line.points)
      if (!p.allFinite())
        throw InputError(path.string() + ":" + std::to_string(line.first_line) +
                         ":1: numbers of this line are too large for the unit");
  return lines;
}

}  // namespace batten
