#include "batten/io/decks/ccx_deck.h"

#include <charconv>
#include <ostream>

namespace batten {
namespace {

constexpr int most_characters = 20;

}  // namespace

std::string ccx_number(double value) {
  char text[40];
  const auto shortest = std::to_chars(text, text + sizeof text, value);
  if (shortest.ptr - text <= most_characters) return {text, shortest.ptr};
  for (int precision = 16;; --precision) {
    const auto rounded =
        std::to_chars(text, text + sizeof text, value, std::chars_format::general, precision);
    if (rounded.ptr - text <= most_characters) return {text, rounded.ptr};
  }
}

std::string ccx_vector(const Vec3& v) {
  return ccx_number(v.x()) + "," + ccx_number(v.y()) + "," + ccx_number(v.z());
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  return text;
}

void write_ccx_ids(std::ostream& out, std::span<const int> ids) {
  constexpr size_t most_a_row = 16;
  for (size_t i = 0; i < ids.size(); ++i)
    out << ids[i] + 1 << ((i + 1) % most_a_row == 0 || i + 1 == ids.size() ? '\n' : ',');
}

}  // namespace batten
