// Reads what acts on a scene's surface: [[constraint]], [[load]], [[weight]], [[move]],
// [[parameter]] and [motion]. Internal.
#pragma once

#include <filesystem>

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads all these tables into the scene, whose lines and [skin] have been read before. `folder`:
/// where paths begin. Throws InputError.
void read_sculpting(const TomlTable& root, const std::filesystem::path& folder, Scene& scene);

}  // namespace batten
