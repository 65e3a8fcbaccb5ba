// What kind of thing a file holds.
#pragma once

#include <filesystem>

namespace batten {

/// What the program takes a file for: by its ending, and where lines and meshes share one, by what
/// is in it. `.obj` with faces is a mesh, `.dat` with grid points a Nastran deck.
enum class FileKind { None, Scene, Mesh, Sequence, Cad, Lines };
FileKind file_kind(const std::filesystem::path& file);

}  // namespace batten
