// Colours of mesh files. Internal.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace batten {

/// Red, green and blue, 0 to 255, of "#rrggbb"; none for "". Throws InputError for another text.
std::optional<std::array<int, 3>> mesh_colour(const std::string& hex);
/// "#rrggbb" of such numbers.
std::string hex_of(const std::array<int, 3>& colour);

}  // namespace batten
