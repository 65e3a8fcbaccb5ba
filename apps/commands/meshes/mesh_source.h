// A mesh file that is ready to be edited.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/features/feature_detection.h"

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


// Describes a mesh file in a few lines of text.

/// Describes a mesh file: counts, defects, the box around it, sets and properties, parts and what
/// hangs on them, boundary loops and proposed features. `unit` is that of its lengths. Throws
/// InputError.
std::string mesh_info(const std::filesystem::path& path, const std::string& unit,
                      const FeatureDetectionOptions& proposals = {});

}  // namespace batten
