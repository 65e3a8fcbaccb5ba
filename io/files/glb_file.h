// The frame of binary glTF files. Internal.
#pragma once

#include <cstdint>
#include <string>

namespace batten {

/// How a GLB file begins, and its two parts.
enum GlbConstant : std::uint32_t {
  kGlbMagic = 0x46546C67,
  kJsonChunk = 0x4E4F534A,
  kBinaryChunk = 0x004E4942
};

/// What glTF calls kinds of numbers, and of what buffers are for.
enum GltfConstant {
  kFloat = 5126,
  kUnsignedInt = 5125,
  kVertexBuffer = 34962,
  kIndexBuffer = 34963
};

/// What stands before the binary part of a GLB file: its head, the JSON part filled up to fours
/// with blanks, and the head of the binary part, whose size is a multiple of four. Both together
/// have less than 4 GB.
std::string glb_header(std::string json, size_t binary_size);
/// The size of what glb_header() returns for a text of this size.
size_t glb_header_size(size_t json_size);

}  // namespace batten
