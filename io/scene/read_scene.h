// Functions that read a scene from one small TOML file (docs/scenes.md has every key). Big data is
// in files of its own, which these functions do not read.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads a scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
Scene read_scene(const std::filesystem::path& file);
/// Reads the same from a text. Messages name `file`; paths in the scene are relative to its folder.
/// `lines_required`: false where a scene is being made, which has no lines at first.
Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  bool lines_required = true);

}  // namespace batten
