// Describes mesh files for `batten info`.
#pragma once

#include <filesystem>
#include <string>

namespace batten {

/// Describes a mesh file: counts, defects, boundary loops and proposed features. `unit` is that of
/// its lengths. Throws InputError.
std::string mesh_info(const std::filesystem::path& file, const std::string& unit);

}  // namespace batten
