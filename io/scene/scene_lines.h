// [[line]] and [[lines]], of any kind of scene. Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/scene/scene.h"

namespace batten {

/// Keys of [[line]] and [[lines]].
std::vector<std::string> line_keys(bool roles);
std::vector<std::string> lines_keys(bool roles);

/// `roles`: whether lines have one (outline, inner). Throws InputError: none at all, too.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles);

}  // namespace batten
