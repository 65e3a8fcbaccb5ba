// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/dxf_text.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "batten/io/files/text.h"

namespace batten {
namespace {

// The value of a code \U+XXXX at position i of a text; -1 if there is none.
long unicode_escape(std::u32string_view text, size_t i) {
  if (text.substr(std::min(i, text.size()), 3) != U"\\U+" || i + 7 > text.size()) return -1;
  long value = 0;
  for (const char32_t c : text.substr(i + 3, 4)) {
    const bool digit = c >= '0' && c <= '9', letter = (c | 32) >= 'a' && (c | 32) <= 'f';
    if (!digit && !letter) return -1;
    value = 16 * value + static_cast<long>(digit ? c - '0' : (c | 32) - 'a' + 10);
  }
  return value;
}

}  // namespace

std::string dxf_decoded(std::string_view text) {
  const std::u32string given = code_points(text);
  std::u32string result;
  for (size_t i = 0; i < given.size(); ++i) {
    const long first = unicode_escape(given, i);
    if (first < 0) {
      result += given[i];
      continue;
    }
    i += 6;
    const long second = unicode_escape(given, i + 1);
    if (first >= 0xD800 && first < 0xDC00 && second >= 0xDC00 && second < 0xE000) {
      result += static_cast<char32_t>(0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00));
      i += 7;
    } else {
      result += first >= 0xD800 && first < 0xE000 ? U'\uFFFD' : static_cast<char32_t>(first);
    }
  }
  return utf8(result);
}

std::string unicode_escapes(char32_t c) {
  const auto escape = [](unsigned value) {
    std::array<char, 16> text;
    std::snprintf(text.data(), text.size(), "\\U+%04X", value);
    return std::string(text.data());
  };
  if (c < 0x10000) return escape(c);
  return escape(0xD800 + ((c - 0x10000) >> 10)) + escape(0xDC00 + ((c - 0x10000) & 0x3FF));
}

std::string dxf_character(char32_t c) {
  return c >= 32 && c < 127 && c != '\\' && c != '^' ? std::string(1, static_cast<char>(c))
                                                     : unicode_escapes(c);
}

}  // namespace batten
