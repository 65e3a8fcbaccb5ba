// The rows of a text file of numbers, and their places for messages.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>
#include <array>
#include <optional>

#include "batten/io/files/text.h"
#include "batten/io/lines/named_lines.h"

namespace batten {

/// The text of one file, gone through row by row. Throws InputError: a file that is missing, a
/// folder, empty, or in UTF-16. A UTF-8 byte-order mark is passed over.
class TextRows {
 public:
  explicit TextRows(const std::filesystem::path& path);

  /// Moves to the next row; false at the end.
  bool next();
  /// The row without its line end; comments are still in it.
  std::string_view row() const { return std::string_view(text_).substr(begin_, end_ - begin_); }
  int line() const { return line_; }  ///< from 1
  const std::filesystem::path& path() const { return path_; }

  /// Throws InputError, "file:line:column: message"; `where` points into the row.
  [[noreturn]] void fail(const char* where, const std::string& message) const;
  /// The number that `field`, a part of the row, is. Throws InputError with its place.
  double number_in(std::string_view field, const std::string& expected) const;

 private:
  std::filesystem::path path_;
  std::string text_;
  size_t begin_ = 0, end_ = 0;
  int line_ = 0;
};

/// Without '#' and '//' comments, and trimmed.
std::string_view without_comment(std::string_view row);
/// Fields of a row: blanks, with at most one comma or semicolon among them, separate.
void split_fields(std::string_view row, std::vector<std::string_view>& fields);
/// Fields between separators, trimmed; ' ': any blanks.
void split_at(std::string_view row, char separator, std::vector<std::string_view>& fields);
/// Whether the field begins like a number, or is "nan" or "inf".
bool starts_like_number(std::string_view field);


// What rows of words above the numbers of a table say: titles, names of columns, offset tables,
// airfoils.

/// Whether a row is a heading: words, which may hold digits ("NACA 2412", "MH 32  8.7%"), and in
/// the first row of a file a number alone, or the corner of an offset table that is empty. A row of
/// numbers with a mistake in it ("1, 2, x", "l.0 0.5") is none, nor one that names an axis beside a
/// number.
bool is_header(std::string_view row, bool first_row);

/// The columns that a header names: x, y, z ("X [mm]", ParaView's "Points:0"), two of them at
/// least, the others 0; and "line", "name" or "curve", of which each change begins a line.
struct HeaderColumns {
  char separator = 0;  ///< 0: blanks, commas and semicolons alike
  std::array<int, 3> axes = {-1, -1, -1};
  int name = -1;  ///< -1: none
  size_t count = 0;
  explicit operator bool() const { return (axes[0] >= 0) + (axes[1] >= 0) + (axes[2] >= 0) > 1; }
};
HeaderColumns parse_header_columns(std::string_view heading);
/// None when the heading has another number of columns than `row`, or no numbers are in these.
HeaderColumns header_columns(std::string_view heading, std::string_view row);

/// A heading as a name: without quotes and blanks at its ends.
std::string header_name(std::string_view heading);

/// A table of half breadths: above it a word (or nothing) and ascending heights of waterlines; each
/// row a station's place along the ship and its half breadths, empty or "-" where there is no hull.
/// When the word begins with "z", "w" or "h", rows are waterlines and columns stations.
class OffsetTable {
 public:
  /// Reads on from the row at which `rows` stands. A line for each station: points (x, half
  /// breadth, z), upwards. Stations with fewer than two points are left out. Throws InputError.
  std::vector<NamedPoints> read(TextRows& rows, double scale) const;

 private:
  friend std::optional<OffsetTable> offset_table(std::string_view heading, std::string_view row);
  char separator_ = 0;
  bool rows_are_waterlines_ = false;
  std::vector<double> heights_;
};
std::optional<OffsetTable> offset_table(std::string_view heading, std::string_view row);

/// Lednicer's airfoils: a row with the numbers of points of both sides, then the upper and the
/// lower side, each from the leading edge. They become one line, from the trailing edge over the
/// upper side to the leading edge and back, as in Selig's format. Other lines are left as they are.
void join_lednicer(std::vector<NamedPoints>& lines, double scale);

std::string_view without_quotes(std::string_view field);
bool is_digits(std::string_view field);  ///< digits only

}  // namespace batten
