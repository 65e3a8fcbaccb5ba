// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"

namespace batten {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  return text;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

bool replace_carriage_returns(std::string& text) {
  if (text.find('\n') != text.npos || text.find('\r') == text.npos) return false;
  std::replace(text.begin(), text.end(), '\r', '\n');
  return true;
}

std::string format_count(long count, const std::string& noun, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? noun : many.empty() ? noun + "s" : many);
}

std::string exact_number(double value) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

std::string single_row(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return text;
}

namespace {

/// A code point, and the number of its bytes; no bytes: the text is not valid UTF-8 there.
struct Decoded {
  char32_t point = 0;
  size_t bytes = 0;
};

Decoded decoded(std::string_view text, size_t at) {
  const auto byte = [&](size_t k) { return static_cast<unsigned char>(text[k]); };
  const auto first = byte(at);
  if (first < 0x80) return {first, 1};
  const size_t more = first < 0xC2 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : first < 0xF5 ? 3 : 0;
  char32_t point = first & (0x3Fu >> more);
  bool valid = more > 0 && at + more < text.size();
  for (size_t k = at + 1; valid && k <= at + more; ++k) {
    valid = (byte(k) & 0xC0) == 0x80;
    point = point << 6 | (byte(k) & 0x3Fu);
  }
  // Sequences that are too long, surrogates, and numbers beyond Unicode are not valid either.
  constexpr std::array<char32_t, 4> least = {0, 0x80, 0x800, 0x10000};
  valid = valid && point >= least[more] && point < 0x110000 && (point & ~0x7FFu) != 0xD800;
  return valid ? Decoded{point, more + 1} : Decoded{};
}

/// True for characters that control a terminal or the order and the lines of a text.
bool is_control(char32_t point) {
  return point < 0x20 || (point >= 0x7F && point < 0xA0) || point == 0x61C ||
         (point >= 0x200E && point <= 0x200F) || (point >= 0x2028 && point <= 0x202E) ||
         (point >= 0x2066 && point <= 0x2069);
}

std::string escape(char32_t point) {
  if (point == '\n') return "\\n";
  if (point == '\t') return "\\t";
  if (point == '\r') return "\\r";
  std::array<char, 8> digits;
  std::snprintf(digits.data(), digits.size(), point < 0x80 ? "\\x%02X" : "\\u%04X",
                static_cast<unsigned>(point));
  return digits.data();
}

}  // namespace

std::string printable(std::string_view text, LineFeeds line_feeds) {
  std::string shown;
  for (size_t i = 0; i < text.size();) {
    const Decoded next = decoded(text, i);
    const bool kept =
        next.point == '\n' &&
        (line_feeds == LineFeeds::Keep ||
         (line_feeds == LineFeeds::KeepBeforeIndent && text.substr(i + 1).starts_with("  ")));
    if (next.bytes == 0) {
      std::array<char, 8> digits;
      std::snprintf(digits.data(), digits.size(), "\\x%02X", static_cast<unsigned char>(text[i]));
      shown += digits.data();
    } else if (is_control(next.point) && !kept) {
      shown += escape(next.point);
    } else {
      shown += text.substr(i, next.bytes);
    }
    i += std::max<size_t>(next.bytes, 1);
  }
  return shown;
}

std::u32string code_points(std::string_view text) {
  std::u32string points;
  for (size_t i = 0; i < text.size();) {
    const Decoded next = decoded(text, i);
    points.push_back(next.bytes > 0 ? next.point : static_cast<unsigned char>(text[i]));
    i += std::max<size_t>(next.bytes, 1);
  }
  return points;
}

std::string utf8(std::u32string_view points) {
  std::string text;
  for (const char32_t point : points) {
    const int more = point < 0x80 ? 0 : point < 0x800 ? 1 : point < 0x10000 ? 2 : 3;
    constexpr std::array<unsigned, 4> lead = {0, 0xC0, 0xE0, 0xF0};
    text += static_cast<char>(lead[static_cast<size_t>(more)] | point >> (6 * more));
    for (int k = more - 1; k >= 0; --k) text += static_cast<char>(0x80 | (point >> (6 * k) & 0x3F));
  }
  return text;
}

namespace {

const std::vector<std::pair<std::string, double>> kUnits = {
    {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};

}  // namespace

const std::vector<std::string>& length_units() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const auto& unit : kUnits) list.push_back(unit.first);
    return list;
  }();
  return names;
}

double unit_in_metres(const std::string& unit) {
  for (const auto& [name, metres] : kUnits)
    if (name == unit) return metres;
  throw InputError("found the unit '" + unit + "', expected " +
                   expected_one_of(unit, length_units()));
}

std::string format_unit(double unit_in_metres) {
  static constexpr std::pair<const char*, double> units[] = {
      {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1},         {"in", 0.0254},   {"ft", 0.3048},
      {"um", 1e-6}, {"km", 1e3},  {"mi", 1609.344}, {"mil", 2.54e-5}, {"uin", 2.54e-8}};
  for (const auto& [name, metres] : units)
    if (std::abs(unit_in_metres - metres) <= 1e-9 * metres) return name;
  return format_number(unit_in_metres) + " m";
}

}  // namespace batten
