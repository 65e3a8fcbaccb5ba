// SPDX-License-Identifier: MPL-2.0
// Numbers and lists of CalculiX decks.
#pragma once

#include <algorithm>
#include <charconv>
#include <ostream>
#include <span>
#include <string>

#include "batten/core/eigen.h"

namespace batten {

/// Formats a number with as many digits as fit into 20 characters; the relative error is at most
/// 1e-13. (ccx reads 20 characters and silently ignores the rest, exponents included.)
inline std::string ccx_number(double value) {
  constexpr int most_characters = 20;
  char text[40];
  const auto shortest = std::to_chars(text, text + sizeof text, value);
  if (shortest.ptr - text <= most_characters) return {text, shortest.ptr};
  for (int precision = 16;; --precision) {
    const auto rounded =
        std::to_chars(text, text + sizeof text, value, std::chars_format::general, precision);
    if (rounded.ptr - text <= most_characters) return {text, rounded.ptr};
  }
}

/// The same with a decimal point, without which ccx takes the stiffness of a spring for a component.
inline std::string ccx_decimal(double value) {
  std::string text = ccx_number(value);
  if (text.find('.') == std::string::npos) text.insert(std::min(text.find('e'), text.size()), ".");
  return text;
}

/// Formats a vector as "x,y,z".
inline std::string ccx_vector(const Vec3& v) {
  return ccx_number(v.x()) + "," + ccx_number(v.y()) + "," + ccx_number(v.z());
}

/// A text for a comment line: control characters such as line ends are replaced by blanks.
inline std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

/// Writes node or element numbers, up to 16 per row. `ids` are 0-based; ccx numbers are 1-based.
inline void write_ccx_ids(std::ostream& out, std::span<const int> ids) {
  constexpr size_t most_a_row = 16;
  for (size_t i = 0; i < ids.size(); ++i)
    out << ids[i] + 1 << ((i + 1) % most_a_row == 0 || i + 1 == ids.size() ? '\n' : ',');
}

}  // namespace batten
