// Reads a mesh file for editing, and describes mesh files as text.
#pragma once

#include <filesystem>
#include <string>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

/// A mesh file, and its prepared (clean, oriented) triangle mesh.
struct MeshSource {
  MeshFile file;
  PreparedMesh prepared;
};

/// Reads and prepares a mesh. Throws InputError that begins with the file name.
MeshSource read_source(const std::filesystem::path& path);

/// Positions of the file's nodes. The mesh may have more vertices than nodes: nodes on non-manifold
/// edges are split per manifold patch.
Points node_positions(const Points& vertices, const MeshFile& file);

// Text descriptions of mesh files.

/// Describes a mesh file: counts, defects, bounding box, sets and properties, components with
/// attached elements, boundary loops and proposed features. `unit`: unit of its lengths. Throws
/// InputError.
std::string mesh_info(const std::filesystem::path& path, const std::string& unit,
                      const FeatureDetectionOptions& proposals = {});

}  // namespace batten
