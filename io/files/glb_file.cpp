#include "batten/io/files/glb_file.h"

#include "batten/io/files/number_bytes.h"

namespace batten {
namespace {

constexpr size_t kHead = 20, kBinaryHead = 8;

size_t in_fours(size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

size_t glb_head_size(size_t json_size) { return kHead + in_fours(json_size) + kBinaryHead; }

std::string glb_head(std::string json, size_t binary_size) {
  json.resize(in_fours(json.size()), ' ');
  std::string head;
  append_unsigned(head, kGlbMagic);
  append_unsigned(head, 2);
  append_unsigned(head, static_cast<std::uint32_t>(glb_head_size(json.size()) + binary_size));
  append_unsigned(head, static_cast<std::uint32_t>(json.size()));
  append_unsigned(head, kJsonChunk);
  head += json;
  append_unsigned(head, static_cast<std::uint32_t>(binary_size));
  append_unsigned(head, kBinaryChunk);
  return head;
}

}  // namespace batten
