// SPDX-License-Identifier: MPL-2.0
// Row-by-row access to text files of numbers, with positions for messages, and the headings of
// tables.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/files/text.h"
#include "batten/io/lines/named_lines.h"

namespace batten {

/// The text of one file, read row by row. Throws InputError for a missing file, a folder, an empty
/// file, and UTF-16 text. A UTF-8 byte-order mark is skipped.
class TextRows {
 public:
  explicit TextRows(const std::filesystem::path& path);

  /// Advances to the next row; false at the end.
  bool next();
  /// The current row without its line end; comments are included.
  std::string_view row() const { return std::string_view(text_).substr(begin_, end_ - begin_); }
  int line() const { return line_; }  ///< 1-based row number
  const std::filesystem::path& path() const { return path_; }

  /// Throws InputError, "file:line:column: message". `where` must point into the row.
  [[noreturn]] void fail(const char* where, const std::string& message) const;
  /// Parses `field`, a part of the row, as a number, which may be in double quotes.
  /// `decimal_comma`: a comma is accepted as decimal sign. Throws InputError with its position.
  double number_in(std::string_view field, const std::string& expected,
                   bool decimal_comma = false) const;

 private:
  std::filesystem::path path_;
  std::string text_;
  size_t begin_ = 0, end_ = 0;
  int line_ = 0;
};

/// The row without '#' and '//' comments, trimmed. Fields in double quotes contain no comments.
std::string_view without_comment(std::string_view row);
/// Splits a row into fields separated by blanks, with at most one comma or semicolon among them.
void split_fields(std::string_view row, std::vector<std::string_view>& fields);
/// Splits a row at `separator` and trims the fields. ' ': any number of blanks. With other
/// separators, a field in double quotes may contain the separator.
void split_at(std::string_view row, char separator, std::vector<std::string_view>& fields);
/// The separator of a row: the first of semicolon, tab and comma that occurs outside of quotes; 0:
/// none of them.
char separator_of(std::string_view row);
/// Removes an empty last field, as after a separator at the end of a row; true if there was one.
bool drop_empty_end(std::vector<std::string_view>& fields);
/// True if the field begins like a number, or is "nan" or "inf".
bool starts_like_number(std::string_view field);

// Headings of tables: titles, column names, offset tables, airfoils.

/// True if a row is a heading. A heading consists of words, which may contain digits ("NACA 2412",
/// "MH 32  8.7%"). In the first row of a file it may also be a single number, or an offset table's
/// header with an empty corner. A row of numbers with a typing error ("1, 2, x", "l.0 0.5") is not
/// a heading, nor is a row with an axis name next to a number.
bool is_header(std::string_view row, bool first_row);

/// The columns that a header names. At least two of x, y, z are needed ("X [mm]", ParaView's
/// "Points:0"); a missing coordinate is 0. A change in the column "line", "name" or "curve" starts
/// a new curve.
struct HeaderColumns {
  char separator = 0;  ///< 0: blanks, commas and semicolons
  /// Column index of x, y and z; -1: none.
  std::array<int, 3> axes = {-1, -1, -1};
  int name = -1;  ///< index of the name column; -1: none
  /// Total number of columns.
  size_t count = 0;
  /// True if at least two axes are named.
  explicit operator bool() const { return (axes[0] >= 0) + (axes[1] >= 0) + (axes[2] >= 0) > 1; }
};
/// Parses a header row.
HeaderColumns parse_header_columns(std::string_view heading);
/// As parse_header_columns(), but empty if `row` has another number of columns or no numbers in the
/// named ones.
HeaderColumns header_columns(std::string_view heading, std::string_view row);

/// The heading as a name: without surrounding quotes and blanks.
std::string header_name(std::string_view heading);

/// A table of the half-breadths of a ship's hull. Its header is a word (or nothing), followed by
/// ascending or descending heights of waterlines. Each row is the position of a station along the
/// ship, followed by its half-breadths; "-" or empty if there is no hull. Positions may be preceded
/// by a word: "WL 150", "Station 3". If the word in the corner or those of the rows name waterlines
/// ("z", "h", "height", "WL", "waterline"), or those of the columns name stations ("x", "station",
/// "frame"), rows are waterlines and columns are stations. If the separator is a semicolon or tab,
/// decimal commas are accepted.
class OffsetTable {
 public:
  /// Reads on from the current row of `rows`. Returns one curve per station, by ascending position,
  /// with points (x, half-breadth, z), upwards. Stations with fewer than two points are left out. Throws
  /// InputError.
  std::vector<NamedPoints> read(TextRows& rows, double scale) const;

 private:
  friend std::optional<OffsetTable> offset_table(std::string_view heading, std::string_view row);
  char separator_ = 0;
  bool rows_are_waterlines_ = false, decimal_commas_ = false;
  std::vector<double> positions_;  // of the columns
};
/// Recognises an offset table by its header and the first row below it.
std::optional<OffsetTable> offset_table(std::string_view heading, std::string_view row);

/// Converts an airfoil in Lednicer's format to a single curve. The format is a row with the numbers
/// of points of both sides, followed by the upper and the lower side, each from the leading edge.
/// The result runs from the trailing edge over the upper side to the leading edge and back, as in
/// Selig's format. Other curves are not changed.
void join_lednicer(std::vector<NamedPoints>& lines, double scale);

/// The field without surrounding quotes and blanks.
std::string_view without_quotes(std::string_view field);
/// The text of a field; in a field in double quotes, two quotes stand for one.
std::string unquoted(std::string_view field);
bool is_digits(std::string_view field);  ///< true for a non-empty field of digits only

}  // namespace batten
