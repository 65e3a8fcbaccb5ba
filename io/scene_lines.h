// [[line]] and [[lines]], of any kind of scene. Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/scene.h"

namespace batten {

/// `roles`: whether lines have one (outline, inner). Throws InputError: none at all, too.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles);

}  // namespace batten
