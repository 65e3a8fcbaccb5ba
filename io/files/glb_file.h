// SPDX-License-Identifier: MPL-2.0
// Helpers for binary glTF (GLB) files.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

namespace batten {

/// The magic number of GLB files and the types of their chunks.
enum GlbConstant : std::uint32_t {
  kGlbMagic = 0x46546C67,
  kJsonChunk = 0x4E4F534A,
  kBinaryChunk = 0x004E4942
};

/// glTF's codes of component types and buffer targets.
enum GltfConstant {
  kFloat = 5126,
  kUnsignedInt = 5125,
  kVertexBuffer = 34962,
  kIndexBuffer = 34963
};

// Conversion of numbers to and from bytes, in either byte order.

/// The unsigned integer at an address; little-endian unless `big_endian`.
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

// The beginning of a GLB file.

/// The smallest multiple of four that is not below `size`: chunks of GLB files have such sizes.
inline size_t padded_to_four(size_t size) { return (size + 3) / 4 * 4; }

/// The size of the result of glb_header() for a JSON text of this size.
inline size_t glb_header_size(size_t json_size) {
  constexpr size_t file_and_json_header = 20, binary_header = 8;
  return file_and_json_header + padded_to_four(json_size) + binary_header;
}

/// Everything before the binary data of a GLB file: file header, JSON chunk (padded with blanks to
/// a multiple of four bytes), and header of the binary chunk. `binary_size` must be a multiple of
/// four. The whole file must be smaller than 4 GB.
inline std::string glb_header(std::string json, size_t binary_size) {
  json.resize(padded_to_four(json.size()), ' ');
  std::string head;
  append_uint32(head, kGlbMagic);
  append_uint32(head, 2);
  append_uint32(head, static_cast<std::uint32_t>(glb_header_size(json.size()) + binary_size));
  append_uint32(head, static_cast<std::uint32_t>(json.size()));
  append_uint32(head, kJsonChunk);
  head += json;
  append_uint32(head, static_cast<std::uint32_t>(binary_size));
  append_uint32(head, kBinaryChunk);
  return head;
}

}  // namespace batten
