// The scene of `batten fit`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Adds the lines of a mesh to a scene with a network as a person would draw them: its creases and rims, named
/// "crease 1" …, "rim 1" …, and as regions "patch 1" … what they enclose. Throws InputError where there are none.
void add_mesh_lines(Scene& scene, const TriangleMesh& mesh);

/// A network of lines whose shape is fitted to a surface: those of the files; where there are none, the edges
/// of a CAD file or the lines of a mesh. STEP and VTP are written.
Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit);

}  // namespace batten
