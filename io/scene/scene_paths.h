// SPDX-License-Identifier: MPL-2.0
// The file paths in the text of a scene, and how they change when the scene moves to another folder.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "batten/io/scene/scene_text.h"

namespace batten {

/// Returns the new text of a path in a scene, or an empty string to keep the path.
using PathChange = std::function<std::string(const std::filesystem::path& file)>;

/// Returns the scene with changed paths: of the mesh, of the sequence, and of all curve, target,
/// point-cloud, comparison and selection files.
SceneText with_paths(SceneText text, const PathChange& change);

/// Returns the scene for another folder: relative paths, which refer to the folder `from`, are
/// replaced by paths relative to the folder `to`. `for_people`: paths that would go up by more than
/// two levels become absolute.
SceneText with_moved_paths(SceneText text, const std::filesystem::path& from,
                           const std::filesystem::path& to, bool for_people = true);

/// Returns the scene with relative paths for those absolute paths that lead into `folder`.
SceneText relative_to_folder(SceneText text, const std::filesystem::path& folder);

/// The folder of a file, as an absolute path without "." and "..".
std::filesystem::path folder_of(const std::filesystem::path& file);

}  // namespace batten
