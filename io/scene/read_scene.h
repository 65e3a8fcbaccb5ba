// Reads a surface scene from a TOML file (all keys: docs/scenes.md). Large data is in separate
// files, which these functions do not read.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/scene.h"

namespace batten {

/// Reads a scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
Scene read_scene(const std::filesystem::path& file);
/// Parses a scene from text. `file` appears in messages, and paths are relative to its folder.
/// `lines_required` = false accepts a scene under construction without lines.
Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  bool lines_required = true);

}  // namespace batten
