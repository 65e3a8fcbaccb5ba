// A mesh file that is ready to be edited.
#pragma once

#include <filesystem>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// The file, and the mesh that mathematics stands on.
struct MeshSource {
  MeshFile file;
  PreparedMesh prepared;
};

/// Reads and prepares a mesh. Throws InputError that begins with the file's name.
MeshSource read_source(const std::filesystem::path& path);

/// Places of the file's nodes: the mesh has more vertices where sheets meet.
Points node_positions(const Points& vertices, const MeshFile& file);

}  // namespace batten
