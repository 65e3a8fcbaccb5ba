#include "batten/io/lines/point_table.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/table_header.h"

namespace batten {
namespace {

using Fields = std::vector<std::string_view>;

// How the rows of a table are divided.
struct Columns {
  char separator = 0;           // 0: as split_fields()
  bool decimal_commas = false;  // "1,5" is one and a half
  long count = 0;               // 0: not known yet
  int line = 0;                 // the row that says so
  HeaderColumns named;          // by a header row
  std::optional<long> number;   // of the point before, where the first of four columns counts them
};

void split(std::string_view row, char separator, Fields& fields) {
  if (separator == 0) return split_fields(row, fields);
  split_at(row, separator, fields);
}

// Whether all fields are numbers written with decimal commas: one of them has a comma at least.
bool has_decimal_commas(const Fields& fields, bool each) {
  bool any = false;
  for (std::string_view f : fields) {
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

// A number of points, which a double and a long hold.
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
        // A row with nothing but a comment does not end a line.
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
  // "CURVE 3" begins a line and names it.
  bool starts_curve(std::string_view row) {
    split_fields(row, fields_);
    if (fields_.size() != 2 || fields_[0] != "CURVE") return false;
    lines_.push_back({"curve " + std::string(fields_[1]), {}, rows_.line()});
    new_line_ = false;
    return true;
  }

  // Words may stand beside the numbers in columns that nobody asked for.
  bool is_heading_here(std::string_view row) const {
    if (columns_.count == 0)
      return !header_columns(heading_, row) && is_header(row, heading_.empty());
    return new_line_ && !columns_.named && is_header(row, false);
  }

  void take_header(std::string_view row) {
    if (columns_.count == 0) {
      // A row of units may follow the names of columns.
      if (!parse_header_columns(heading_)) heading_ = row;
      return;
    }
    // Headings of blocks name them; then the first names the first one.
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
    split(row, columns_.separator, fields_);
    columns_.count = isize(fields_);
    if (columns_.named) {
      how_ = "columns named by the header";
    } else if (columns_.count == 4 && is_count(fields_[0])) {
      columns_.number = static_cast<long>(value(fields_[0])) - 1;
      how_ = "the first column counts the points";
    } else if (columns_.count != 2 && columns_.count != 3) {
      const bool commas = row.find(';') != row.npos && row.find(',') != row.npos;
      rows_.fail(row.data(),
                 "found " + format_count(columns_.count, "column") + ", expected 2 or 3 (x, y, z)" +
                     (columns_.count > 3 ? ", or a header row that names those columns" : "") +
                     (commas ? "; numbers are written with a decimal point" : ""));
    }
    if (columns_.decimal_commas) how_ += std::string(how_.empty() ? "" : ", ") + "decimal commas";
  }

  // Between semicolons, tabs or blanks a comma inside a number is a decimal one.
  void choose_decimal_commas(std::string_view row) {
    if (columns_.separator == ',') return;
    const bool semicolons = row.find(';') != row.npos;
    split_at(row, semicolons ? ';' : ' ', fields_);
    if (fields_.size() < 2 || !has_decimal_commas(fields_, !semicolons)) return;
    columns_.decimal_commas = true;
    columns_.separator = semicolons ? ';' : ' ';
  }

  Vec3 point(std::string_view row) {
    split(row, columns_.separator, fields_);
    if (columns_.named) return named_point(row);
    size_t first = 0;
    if (columns_.number) {
      first = 1;
      const long next = ++*columns_.number;
      if (fields_.size() == 4 && value(fields_[0]) != static_cast<double>(next)) {
        // Each line may count its own points.
        if (!new_line_ || !is_count(fields_[0]))
          rows_.fail(
              row.data(),
              "found " + quoted_excerpt(fields_[0]) + " in the first of 4 columns, expected " +
                  std::to_string(next) +
                  " as it counts the points, or a header row that names the columns x, y, z");
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
      const std::string name(without_quotes(fields_[static_cast<size_t>(columns_.named.name)]));
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
    static const std::string expected = "a number",
                             headed = "a number (a header row has words only)";
    const std::string& what = lines_.empty() && heading_.empty() ? headed : expected;
    const size_t comma = columns_.decimal_commas ? field.find(',') : field.npos;
    if (comma == field.npos) return rows_.number_in(field, what);
    std::string with_point(field);
    with_point[comma] = '.';
    double x = 0;
    const auto [end, error] =
        std::from_chars(with_point.data(), with_point.data() + with_point.size(), x);
    if (error != std::errc() || end != with_point.data() + with_point.size() || !std::isfinite(x))
      rows_.fail(field.data(), "found " + quoted_excerpt(field) + ", expected " + what);
    return x;
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
    for (const NamedPoints& line : lines_)
      if (line.points.size() < 2)
        throw InputError(rows_.path().string() + ":" + std::to_string(line.first_line) +
                         ":1: found a line of " + format_count(isize(line.points), "point") +
                         ", expected 2 or more");
  }

  TextRows& rows_;
  double scale_;
  Columns columns_;
  std::string_view heading_;  // the last row of words
  std::string title_, next_name_, how_;
  Fields fields_;
  std::vector<NamedPoints> lines_;
  bool new_line_ = true;
};

}  // namespace

std::vector<NamedPoints> read_point_table(TextRows& rows, double scale) {
  return PointTable(rows, scale).read();
}

}  // namespace batten
