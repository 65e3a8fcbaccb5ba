// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/dxf_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// Parses a field with blanks around it; std::from_chars does not accept a leading plus.
template <class Number>
std::errc parse(std::string_view field, Number& value) {
  field = trimmed(field);
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end != field.data() + field.size() ? std::errc::invalid_argument
                                                                    : error;
}

// True for a word such as LINE, 3DFACE or ACAD_TABLE.
bool is_type(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  return std::any_of(text.begin(), text.end(), is_letter) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace

DxfReader::DxfReader(const std::filesystem::path& path) : path_(path) {
  text_ = read_input_file(path, "a drawing");
  if (text_.starts_with("AutoCAD Binary DXF"))
    throw InputError(path.string() + ": found a binary DXF file, expected one in text form");
  if (text_.starts_with("AC10"))
    throw InputError(path.string() + ": found a DWG file, expected DXF");
  if (text_.find("SECTION") == text_.npos)
    throw InputError(path.string() + ": found no section, expected a DXF file");
  if (text_.starts_with("\xEF\xBB\xBF")) position_ = 3;
  replace_carriage_returns(text_);
  text_.erase(text_.find_last_not_of(" \t\r\n") + 1);
  read_groups();
}

bool DxfReader::next() {
  if (next_type_.line == 0)
    throw InputError(path_.string() + ":" + std::to_string(line_) +
                     ": found the end of the file, expected EOF: the file is truncated");
  type_ = next_type_;
  type_.value = trimmed(type_.value);
  if (!is_type(type_.value))
    throw InputError(path_.string() + ":" + std::to_string(type_.line) + ": found " +
                     quoted_excerpt(type_.value) + ", expected the type of an entity or object");
  if (type_.value == "EOF") return false;
  read_groups();
  return true;
}

void DxfReader::read_groups() {
  groups_.clear();
  next_type_ = {};
  bool of_application = false;
  for (DxfGroup group; read_group(group);) {
    if (group.code == 0) {
      next_type_ = group;
      return;
    }
    if (group.code == 102) {
      of_application = group.value.starts_with('{');
    } else if (!of_application && group.code != 999) {
      groups_.push_back(group);
    }
  }
}

bool DxfReader::read_line(std::string_view& line) {
  if (position_ >= text_.size()) return false;
  const size_t end = std::min(text_.find('\n', position_), text_.size());
  line = std::string_view(text_).substr(position_, end - position_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  position_ = end + 1;
  ++line_;
  return true;
}

bool DxfReader::read_group(DxfGroup& group) {
  std::string_view code;
  if (!read_line(code)) return false;
  if (parse(code, group.code) != std::errc())
    throw InputError(path_.string() + ":" + std::to_string(line_) + ": found " +
                     quoted_excerpt(code) + ", expected a group code of a DXF file");
  const bool complete = read_line(group.value);
  group.line = line_;
  return complete;
}

void DxfReader::fail(const DxfGroup& group, const std::string& expected) const {
  throw InputError(path_.string() + ":" + std::to_string(group.line) + ": found " +
                   quoted_excerpt(group.value) + " with group code " + std::to_string(group.code) +
                   " of " + std::string(type()) + ", expected " + expected);
}

const DxfGroup* DxfReader::find(int code) const {
  const auto found = std::find_if(groups_.rbegin(), groups_.rend(),
                                  [&](const DxfGroup& group) { return group.code == code; });
  return found == groups_.rend() ? nullptr : &*found;
}

std::string_view DxfReader::text(int code) const {
  const DxfGroup* group = find(code);
  return group ? group->value : std::string_view();
}

double DxfReader::number(const DxfGroup& group) const {
  std::string field(group.value);
  std::replace(field.begin(), field.end(), ',', '.');
  double value = 0;
  const std::errc error = parse(field, value);
  if (error == std::errc::invalid_argument) fail(group, "a number");
  if (error != std::errc() || !(std::abs(value) <= 1e100))
    fail(group, "a number between -1e100 and 1e100, and not below 1e-307");
  return value;
}

int DxfReader::integer(const DxfGroup& group) const {
  const double value = number(group);
  if (value != std::trunc(value) || std::abs(value) > std::numeric_limits<int>::max())
    fail(group, "an integer");
  return static_cast<int>(value);
}

double DxfReader::number(int code, double otherwise) const {
  const DxfGroup* group = find(code);
  return group ? number(*group) : otherwise;
}

int DxfReader::integer(int code, int otherwise) const {
  const DxfGroup* group = find(code);
  return group ? integer(*group) : otherwise;
}

Vec3 DxfReader::point(int code, const Vec3& otherwise) const {
  return {number(code, otherwise.x()), number(code + 10, otherwise.y()),
          number(code + 20, otherwise.z())};
}

}  // namespace batten
