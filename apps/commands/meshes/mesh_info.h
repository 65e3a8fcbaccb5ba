// The part of `batten info` for meshes.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

/// What is in a mesh file: counts, what is wrong with it, its boundary loops and proposed features.
std::string mesh_info(const std::filesystem::path& file, const std::string& unit);

}  // namespace batten
