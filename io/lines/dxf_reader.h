// SPDX-License-Identifier: MPL-2.0
// Splits DXF files into records of group codes and values.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A group of a DXF file: the group code in one line and the value in the next one.
struct DxfGroup {
  int code = 0;
  std::string_view value;  ///< with the blanks at its ends, which belong to texts
  int line = 0;            ///< 1-based line of the value
};

/// Reads an ASCII DXF file record by record. A record is a group with code 0, whose value is the
/// type of the record (SECTION, LINE, …), and the groups up to the next code 0. Comments (code 999)
/// and groups of applications (between code 102 with "{NAME" and code 102 with "}") are skipped.
///
/// Functions with a group code return the value of the last group of the record with this code. A
/// decimal comma in a number is read as a point.
class DxfReader {
 public:
  /// Throws InputError if the file cannot be read, is a binary DXF or DWG file, or has no section.
  explicit DxfReader(const std::filesystem::path& path);

  /// Advances to the next record; false at the record EOF. Throws InputError ("file:line: found X,
  /// expected Y") for a group code that is not an integer, and if the file ends without EOF.
  bool next();

  std::string_view type() const { return type_.value; }
  int line() const { return type_.line; }  ///< 1-based line of the type
  const std::vector<DxfGroup>& groups() const { return groups_; }
  const std::filesystem::path& path() const { return path_; }

  std::string_view text(int code) const;  ///< empty if there is no such group
  /// A number; `otherwise` if there is no such group. Throws InputError with the line of a value
  /// that is not a finite number (integer(): not an integer).
  double number(int code, double otherwise = 0) const;
  int integer(int code, int otherwise = 0) const;
  double number(const DxfGroup& group) const;
  int integer(const DxfGroup& group) const;
  /// The point with the group codes `code`, `code` + 10 and `code` + 20.
  Vec3 point(int code, const Vec3& otherwise = Vec3::Zero()) const;

 private:
  const DxfGroup* find(int code) const;
  void read_groups();
  bool read_group(DxfGroup& group);
  bool read_line(std::string_view& line);
  [[noreturn]] void fail(const DxfGroup& group, const std::string& expected) const;

  std::filesystem::path path_;
  std::string text_;
  size_t position_ = 0;
  int line_ = 0;
  DxfGroup type_, next_type_;
  std::vector<DxfGroup> groups_;
};

}  // namespace batten
