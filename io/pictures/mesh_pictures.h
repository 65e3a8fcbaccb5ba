// Pictures of shell meshes: what a deformation did, side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// One picture of a mesh, drawn as PictureScene is: parallel projection, z upwards.
struct MeshPicture {
  enum class Part { Body, Feature, Handle, Fixed };

  const ShellMesh* shells = nullptr;
  Points points;                        ///< of its nodes, where they are to be drawn
  std::vector<Part> parts;              ///< of each face; empty: all body
  std::vector<std::vector<int>> lines;  ///< chains of nodes, as tubes
  VecX field;                           ///< a number above 0 for each node, as colours; empty: none
  std::string field_title;
  double field_limit = 0;  ///< end of its scale; 0: from the numbers
  std::string title;
  bool mesh = false;  ///< element edges
  double azimuth = -30, elevation = 30, zoom = 1;
  /// What else has to be in view, so that several pictures can be compared.
  std::vector<const Points*> also_in_view;
};

/// Draws the pictures into one PNG, row by row, titles as captions below them (above a single one).
/// Normals are smoothed where neighbouring faces differ by less than 30 degrees. Main thread only,
/// needs a display (require_display). Throws InputError.
void draw_meshes(const std::filesystem::path& path, const std::vector<MeshPicture>& pictures,
                 int columns, const PictureSize& size = {});

}  // namespace batten
