// A mesh file whose coordinates are replaced in its text. Internal.
#pragma once

#include <array>
#include <vector>

#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_source_text.h"
#include "batten/io/meshes/node_coordinate_systems.h"

namespace batten {

/// The content of a mesh file in which coordinates are replaced field by field.
struct TextMeshContent : MeshContent {
  explicit TextMeshContent(MeshSourceText file) : file(std::move(file)) {}
  MeshRounding write(const std::filesystem::path& path, const Points& points,
                     const MeshWriteOptions& options) const override;
  std::vector<std::filesystem::path> included_files() const override;

  /// Adds a warning for each included file that is not written with the deck.
  void warn_about_unwritten_includes();

  MeshSourceText file;
  std::vector<std::array<Field, 3>> fields;  ///< the fields of each node's three numbers
  NodeCoordinateSystems systems;             ///< what these numbers mean
  /// Why a node must stay where it is, as "a coordinate that is the parameter <x>"; few have it.
  std::vector<std::pair<int, std::string>> fixed_nodes;
};

/// Makes the places of a mesh's nodes of the numbers that are in shells.points, and keeps these.
/// Throws as CoordinateFrameResolver does.
void nodes_to_global(TextMeshContent& mesh, NodeCoordinateSystems systems);

}  // namespace batten
