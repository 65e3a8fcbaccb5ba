#include "batten/io/files/glb_file.h"

namespace batten {
namespace {

constexpr size_t kHead = 20, kBinaryHead = 8;

size_t in_fours(size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

size_t glb_header_size(size_t json_size) { return kHead + in_fours(json_size) + kBinaryHead; }

std::string glb_header(std::string json, size_t binary_size) {
  json.resize(in_fours(json.size()), ' ');
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
