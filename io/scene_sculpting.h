// What acts on a scene's surface: [[constraint]], [[load]], [[weight]], [[move]], [[parameter]],
// [motion]. Internal.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene.h"

namespace batten {

/// Reads them all into the scene, whose lines and [skin] were read before. Throws InputError.
void read_sculpting(const TomlTable& root, const std::filesystem::path& folder, Scene& scene);

/// "from 0 to 10", "from 0 up", "up to 10".
std::string range_text(double min, double max);

}  // namespace batten
