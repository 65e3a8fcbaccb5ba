// The rows of a text file of numbers, and their places for messages.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "batten/io/files/text.h"

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

}  // namespace batten
