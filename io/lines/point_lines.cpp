// SPDX-License-Identifier: MPL-2.0
// Reads curves that are given by points: tables, offset tables, airfoils, strokes and OBJ files.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/lines/named_lines.h"
#include "batten/io/lines/text_rows.h"

namespace batten {

// Point tables: one point per row, offset tables, airfoils.

/// Reads the curves of a .csv, .txt, .xyz or .dat table as documented at read_point_lines(). Curves
/// that the file does not name get an empty name. Throws InputError.
std::vector<NamedPoints> read_point_table(TextRows& rows, double scale);

namespace fs = std::filesystem;
namespace {

/// The tokens of an OBJ record. A backslash continues the record in the next row.
class ObjTokens {
 public:
  explicit ObjTokens(TextRows& rows) : rows_(rows), rest_(without_comment(rows.row())) {}
  /// The next token; empty at the end of the record.
  std::string_view next() {
    for (;;) {
      while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
      if (rest_ != "\\" || !rows_.next()) break;
      rest_ = without_comment(rows_.row());
    }
    size_t length = 0;
    while (length < rest_.size() && !is_blank(rest_[length]) && rest_.substr(length) != "\\")
      ++length;
    const std::string_view token = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return token;
  }

 private:
  TextRows& rows_;
  std::string_view rest_;
};

std::vector<NamedPoints> read_obj(TextRows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<Vec3> vertices;
  std::string name;
  while (rows.next()) {
    const int line = rows.line();
    ObjTokens tokens(rows);
    const std::string_view record = tokens.next();
    const auto end_of_row = [&] { return rows.row().data() + rows.row().size(); };
    if (record == "o" || record == "g") {
      name = trimmed(trimmed(rows.row()).substr(1));  // with '#', which is no comment here
    } else if (record == "v") {
      Vec3 point;
      for (int i = 0; i < 3; ++i) {
        const std::string_view token = tokens.next();
        if (token.empty())
          rows.fail(end_of_row(),
                    "found " + format_count(i, "coordinate") + ", expected 3 (v x y z)");
        point[i] = scale * rows.number_in(token, "a number");
      }
      vertices.push_back(point);
    } else if (record == "l") {
      NamedPoints result{name, {}, line};
      const long count = static_cast<long>(vertices.size());
      for (std::string_view token = tokens.next(); !token.empty(); token = tokens.next()) {
        // Of "vertex/texture", use the first number.
        const std::string_view digits = token.substr(0, token.find('/'));
        long index = 0;
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), index);
        if (digits.empty() || end != digits.data() + digits.size() || error != std::errc())
          rows.fail(token.data(), "found " + quoted_excerpt(token) + ", expected a vertex number");
        const long vertex = index < 0 ? count + index : index - 1;
        if (index == 0 || vertex < 0 || vertex >= count)
          rows.fail(token.data(), "found vertex number " + std::to_string(index) + ", expected " +
                                      (count ? "1 to " + std::to_string(count) + " or -1 to -" +
                                                   std::to_string(count)
                                             : std::string("vertices (v records) before it")));
        result.points.push_back(vertices[vertex]);
      }
      if (result.points.size() < 2)
        rows.fail(end_of_row(), "found a curve with " +
                                    format_count(static_cast<long>(result.points.size()), "point") +
                                    ", expected 2 or more");
      lines.push_back(std::move(result));
    }
  }
  if (!vertices.empty() && lines.empty())
    throw InputError(rows.path().string() + ": found " +
                     format_count(static_cast<long>(vertices.size()), "vertex record") +
                     " but no curve, expected records 'l 1 2 3 …'");
  return chain_segments(std::move(lines));
}

/// Parses the number of points N in a row "v N".
long announced_points(const TextRows& rows, std::string_view row) {
  std::vector<std::string_view> fields;
  split_fields(row, fields);
  if (fields[0] != "v")
    rows.fail(fields[0].data(), "found " + quoted_excerpt(fields[0]) +
                                    ", expected 'v N' before the N points of a curve");
  if (fields.size() != 2)
    rows.fail(fields[0].data(), "found " +
                                    format_count(static_cast<long>(fields.size()) - 1, "word") +
                                    " after 'v', expected the number of points");
  long count = 0;
  const char *first = fields[1].data(), *last = first + fields[1].size();
  const auto [end, error] = std::from_chars(first, last, count);
  if (error != std::errc() || end != last || count < 1)
    rows.fail(first, "found " + quoted_excerpt(fields[1]) + ", expected a number of points from 1");
  return count;
}

std::vector<NamedPoints> read_curves(TextRows& rows, double scale) {
  std::vector<NamedPoints> lines;
  std::vector<std::string_view> fields;
  long missing = 0;
  const auto announced = [&] {
    const auto& line = lines.back();
    return format_count(static_cast<long>(line.points.size()), "point") + ", expected " +
           std::to_string(missing + static_cast<long>(line.points.size())) + " as stated in line " +
           std::to_string(line.first_line);
  };
  while (rows.next()) {
    const std::string_view row = without_comment(rows.row());
    if (row.empty()) continue;
    if (missing == 0) {
      missing = announced_points(rows, row);
      lines.push_back({"", {}, rows.line()});
      continue;
    }
    split_fields(row, fields);
    if (fields[0] == "v") rows.fail(row.data(), "found the next curve after " + announced());
    if (fields.size() != 3)
      rows.fail(row.data(), "found " + format_count(static_cast<long>(fields.size()), "number") +
                                ", expected 3 (x y z)");
    Vec3 point;
    for (int i = 0; i < 3; ++i) point[i] = scale * rows.number_in(fields[i], "a number");
    lines.back().points.push_back(point);
    --missing;
  }
  if (missing > 0)
    throw InputError(rows.path().string() + ":" + std::to_string(rows.line()) +
                     ":1: found the end of the file after " + announced());
  return lines;
}

}  // namespace

std::vector<NamedPoints> read_point_lines(const fs::path& path, double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw InputError(path.string() + ": found a unit factor of " + format_number(scale) +
                     ", expected a number above 0");
  const std::string extension = lower_extension(path);
  static const std::vector<std::string> tables{".csv", ".txt", ".xyz", ".dat"};
  const bool obj = extension == ".obj", curves = extension == ".curves";
  if (!obj && !curves && std::find(tables.begin(), tables.end(), extension) == tables.end())
    throw InputError(path.string() + ": found " +
                     (extension.empty() ? "no extension" : "the extension '" + extension + "'") +
                     ", expected .csv, .txt, .xyz, .dat, .obj or .curves");
  TextRows rows(path);
  std::vector<NamedPoints> lines = obj      ? read_obj(rows, scale)
                                   : curves ? read_curves(rows, scale)
                                            : read_point_table(rows, scale);
  if (lines.empty())
    throw InputError(path.string() + ":1:1: found no points, expected at least one");
  std::vector<std::string*> names;
  for (NamedPoints& line : lines) names.push_back(&line.name);
  make_names_unique(names, path.stem().string());
  for (const auto& line : lines)
    for (const Vec3& p : line.points)
      if (!p.allFinite())
        throw InputError(path.string() + ":" + std::to_string(line.first_line) +
                         ":1: found coordinates that are too large after conversion of the unit, "
                         "expected smaller numbers");
  return lines;
}

namespace {

using Fields = std::vector<std::string_view>;

// The column layout of a table.
struct Columns {
  char separator = 0;           // 0: as in split_fields()
  bool decimal_commas = false;  // "1,5" means one and a half
  long count = 0;               // number of columns; 0: not known yet
  int line = 0;                 // the row that determined the layout
  HeaderColumns named;          // columns named by a header row
  // Index of the previous point, if the first of four columns counts the points.
  std::optional<long> number;
};

// Splits a row. A separator at its end is passed over unless the row then has fewer than `count`
// fields; the result is true if there was one.
bool split(std::string_view row, char separator, long count, Fields& fields) {
  if (separator == 0)
    split_fields(row, fields);
  else
    split_at(row, separator, fields);
  return isize(fields) > count && drop_empty_end(fields);
}

// True if the fields are numbers with decimal commas, at least one of them. `each`: every field
// must have a comma.
bool has_decimal_commas(const Fields& fields, bool each) {
  bool any = false;
  for (std::string_view f : fields) {
    f = without_quotes(f);
    const size_t comma = f.find(',');
    if (comma == f.npos && !each) continue;
    if (comma == f.npos || comma == 0 || comma + 1 == f.size() ||
        f.find(',', comma + 1) != f.npos ||
        !std::isdigit(static_cast<unsigned char>(f[comma - 1])) ||
        !std::isdigit(static_cast<unsigned char>(f[comma + 1])))
      return false;
    any = true;
  }
  return any;
}

// True for a number of points that both double and long can represent.
bool is_count(std::string_view field) {
  constexpr size_t most_digits = 15;
  return field.size() <= most_digits && is_digits(field);
}

class PointTable {
 public:
  PointTable(TextRows& rows, double scale) : rows_(rows), scale_(scale) {}

  std::vector<NamedPoints> read() {
    while (rows_.next()) {
      const std::string_view row = without_comment(rows_.row());
      if (row.find_first_not_of(" \t,;") == row.npos) {
        // A row that contains only a comment does not end a curve.
        if (rows_.row().find_first_of("#/") == std::string_view::npos) new_line_ = true;
        continue;
      }
      if (starts_curve(row)) continue;
      if (columns_.count == 0)
        if (std::optional<OffsetTable> offsets = offset_table(heading_, row))
          return offsets->read(rows_, scale_);
      if (is_heading_here(row)) {
        take_header(row);
        continue;
      }
      if (columns_.count == 0) choose_columns(row);
      add(point(row));
    }
    finish();
    return std::move(lines_);
  }

 private:
  // A row "CURVE 3" starts a curve and names it.
  bool starts_curve(std::string_view row) {
    split_fields(row, fields_);
    if (fields_.size() != 2 || fields_[0] != "CURVE") return false;
    lines_.push_back({"curve " + std::string(fields_[1]), {}, rows_.line()});
    new_line_ = false;
    return true;
  }

  // Rows with named columns may contain words in other columns, so they are not headings.
  bool is_heading_here(std::string_view row) const {
    if (columns_.count == 0)
      return !header_columns(heading_, row) && is_header(row, heading_.empty());
    return new_line_ && !columns_.named && is_header(row, false);
  }

  void take_header(std::string_view row) {
    if (columns_.count == 0) {
      // A row of units may follow the column names.
      if (!parse_header_columns(heading_)) heading_ = row;
      return;
    }
    // Headings name the blocks that follow them; so the title names the first block.
    if (!title_.empty() && lines_.front().name.empty()) lines_.front().name = title_;
    next_name_ = header_name(row);
  }

  void choose_columns(std::string_view row) {
    columns_.line = rows_.line();
    columns_.named = header_columns(heading_, row);
    if (columns_.named) {
      columns_.separator = columns_.named.separator;
    } else {
      title_ = header_name(heading_);
      if (!title_.empty()) how_ = "title " + quoted_excerpt(title_);
    }
    choose_decimal_commas(row);
    const bool ends_with_separator = split(row, columns_.separator, static_cast<long>(columns_.named.count), fields_);
    columns_.count = isize(fields_);
    if (columns_.named) {
      how_ = "columns named by the header";
    } else if (columns_.count == 4 && is_count(fields_[0])) {
      columns_.number = static_cast<long>(value(fields_[0])) - 1;
      how_ = "the first column is a point number";
    } else if (columns_.count != 2 && columns_.count != 3) {
      const bool commas = row.find(';') != row.npos && row.find(',') != row.npos;
      rows_.fail(row.data(),
                 "found " + format_count(columns_.count, "column") + ", expected 2 or 3 (x, y, z)" +
                     (columns_.count > 3 ? ", or a header row that names those columns" : "") +
                     (commas ? "; numbers are written with a decimal point" : ""));
    }
    const auto note = [&](const char* text) { how_ += (how_.empty() ? "" : ", ") + std::string(text); };
    if (row.find('"') != row.npos) note("fields in quotes");
    if (ends_with_separator) note("a separator at the end of each row");
  }

  // Between semicolons or tabs and inside of quotes, a comma in a number is a decimal comma; between
  // blanks only if all numbers of the first row have one.
  void choose_decimal_commas(std::string_view row) {
    const bool quoted = row.find('"') != row.npos, semicolons = row.find(';') != row.npos;
    if (quoted || semicolons) {
      if (columns_.separator == 0) columns_.separator = separator_of(row);
      columns_.decimal_commas = quoted || columns_.separator != ',';
      return;
    }
    if (columns_.separator == ',') return;
    split_at(row, ' ', fields_);
    if (fields_.size() < 2 || !has_decimal_commas(fields_, row.find('\t') == row.npos)) return;
    columns_.decimal_commas = true;
    columns_.separator = ' ';
  }

  Vec3 point(std::string_view row) {
    split(row, columns_.separator, columns_.count, fields_);
    if (columns_.named) return named_point(row);
    size_t first = 0;
    if (columns_.number) {
      first = 1;
      const long next = ++*columns_.number;
      if (fields_.size() == 4 && value(fields_[0]) != static_cast<double>(next)) {
        // Each curve may restart the count of its points.
        if (!new_line_ || !is_count(fields_[0]))
          rows_.fail(row.data(),
                     "found " + quoted_excerpt(fields_[0]) +
                         " in the first of 4 columns, expected " + std::to_string(next) +
                         " as point number, or a header row that names the columns x, y, z");
        columns_.number = static_cast<long>(value(fields_[0]));
      }
    }
    Vec3 p = Vec3::Zero();
    for (size_t i = first; i < fields_.size(); ++i) {
      if (fields_[i].empty())
        rows_.fail(fields_[i].data(),
                   "found an empty column " + std::to_string(i + 1) + ", expected a number");
      const double x = value(fields_[i]);
      if (i - first < 3) p[static_cast<long>(i - first)] = scale_ * x;
    }
    check_count(row);
    return p;
  }

  Vec3 named_point(std::string_view row) {
    check_count(row);
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
      if (const int column = columns_.named.axes[static_cast<size_t>(i)]; column >= 0)
        p[i] = scale_ * value(fields_[static_cast<size_t>(column)]);
    if (columns_.named.name >= 0) {
      const std::string name = unquoted(fields_[static_cast<size_t>(columns_.named.name)]);
      new_line_ = new_line_ || lines_.empty() || lines_.back().name != name;
      next_name_ = name;
    }
    return p;
  }

  void check_count(std::string_view row) const {
    if (isize(fields_) == columns_.count) return;
    rows_.fail(row.data(), "found " + format_count(isize(fields_), "column") + ", expected " +
                               std::to_string(columns_.count) + " as in line " +
                               std::to_string(columns_.line));
  }

  double value(std::string_view field) {
    decimal_commas_used_ =
        decimal_commas_used_ || (columns_.decimal_commas && field.find(',') != field.npos);
    const bool headed = lines_.empty() && heading_.empty();
    return rows_.number_in(
        field, headed ? "a number (a header row contains names only)" : "a number",
        columns_.decimal_commas);
  }

  void add(const Vec3& p) {
    if (std::exchange(new_line_, false)) {
      lines_.push_back({std::exchange(next_name_, ""), {}, rows_.line()});
      if (lines_.size() == 1) lines_[0].format_note = how_;
    }
    lines_.back().points.push_back(p);
  }

  void finish() {
    join_lednicer(lines_, scale_);
    if (std::string& note = lines_.empty() ? how_ : lines_[0].format_note; decimal_commas_used_)
      note += (note.empty() ? "" : ", ") + std::string("decimal commas");
    for (const NamedPoints& line : lines_)
      if (line.points.size() < 2)
        throw InputError(rows_.path().string() + ":" + std::to_string(line.first_line) +
                         ":1: found a curve with " + format_count(isize(line.points), "point") +
                         ", expected 2 or more");
  }

  TextRows& rows_;
  double scale_;
  Columns columns_;
  std::string_view heading_;  // the last row of words before the numbers
  std::string title_, next_name_, how_;
  Fields fields_;
  std::vector<NamedPoints> lines_;
  bool new_line_ = true, decimal_commas_used_ = false;
};

}  // namespace

std::vector<NamedPoints> read_point_table(TextRows& rows, double scale) {
  return PointTable(rows, scale).read();
}

}  // namespace batten
