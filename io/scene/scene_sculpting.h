// What acts on a scene's surface: [[constraint]], [[load]], [[weight]], [[move]], [[parameter]],
// [motion]. Internal.
#pragma once

#include <filesystem>

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads them all into the scene, whose lines and [skin] were read before. Throws InputError.
void read_sculpting(const TomlTable& root, const std::filesystem::path& folder, Scene& scene);

}  // namespace batten
