// Scenes from one small TOML file (docs/scenes.md has every key). Big data stays in its own files
// beside it; this reads the scene only, not those files.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/scene/scene.h"

namespace batten {

/// Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
Scene read_scene(const std::filesystem::path& file);
/// The same from a text; `file` is what messages call it and where its files are looked for.
Scene parse_scene(const std::string& text, const std::filesystem::path& file);

}  // namespace batten
