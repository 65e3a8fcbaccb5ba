// Reads [[line]] and [[lines]] of any kind of scene. Internal.
#pragma once

#include <filesystem>
#include <vector>

#include "batten/io/scene/scene.h"

namespace batten {

/// Keys that [[line]] and [[lines]] may have; `roles` as in read_scene_lines().
std::vector<std::string> line_keys(bool roles);
std::vector<std::string> lines_keys(bool roles);

/// Reads all lines of a scene. `roles`: whether lines of this kind of scene have a role (outline,
/// hole, inner) and a treatment. `folder`: where paths begin. Throws InputError, also when there is
/// no line and one is required.
std::vector<SceneLine> read_scene_lines(const TomlTable& root, const std::filesystem::path& folder,
                                        bool roles, bool required = true);

}  // namespace batten
