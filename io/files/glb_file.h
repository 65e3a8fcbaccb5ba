// The frame of binary glTF files. Internal.
#pragma once

#include <string>

namespace batten {

/// What stands before the binary part of a GLB file: its head, the JSON part filled up to fours
/// with blanks, and the head of the binary part, whose size is a multiple of four. Both together
/// have less than 4 GB.
std::string glb_head(std::string json, size_t binary_size);
/// The size of what glb_head() returns for a text of this size.
size_t glb_head_size(size_t json_size);

}  // namespace batten
