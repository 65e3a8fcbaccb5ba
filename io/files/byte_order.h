// Numbers as bytes of either order. Internal.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace batten {

/// The whole number of `Size` bytes at an address; little end first unless `big_endian`.
template <class Unsigned>
Unsigned load_unsigned(const char* bytes, bool big_endian = false) {
  Unsigned value = 0;
  for (size_t i = 0; i < sizeof value; ++i) {
    const size_t at = big_endian ? i : sizeof value - 1 - i;
    value = static_cast<Unsigned>(static_cast<std::uint64_t>(value) << 8 |
                                  static_cast<unsigned char>(bytes[at]));
  }
  return value;
}

inline float load_float32(const char* bytes, bool big_endian = false) {
  return std::bit_cast<float>(load_unsigned<std::uint32_t>(bytes, big_endian));
}

inline void append_uint32(std::string& out, std::uint32_t value, bool big_endian = false) {
  for (int i = 0; i < 4; ++i)
    out += static_cast<char>(value >> (big_endian ? 24 - 8 * i : 8 * i) & 255);
}

inline void append_float32(std::string& out, float value, bool big_endian = false) {
  append_uint32(out, std::bit_cast<std::uint32_t>(value), big_endian);
}

}  // namespace batten
