// Pictures of shell meshes, such as before and after a deformation, side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// One picture of a mesh. As in PictureScene, projection is parallel and z points upwards.
struct MeshPicture {
  enum class Part { Body, Feature, Handle, Fixed };

  const ShellMesh* shells = nullptr;
  Points points;                        ///< places where its nodes are drawn, n×3
  std::vector<Part> parts;              ///< part of each face, as its colour; empty: all Body
  std::vector<std::vector<int>> lines;  ///< lists of nodes that are drawn as tubes
  VecX field;                           ///< a number ≥ 0 for each node, as colours; empty: none
  std::string field_title;
  double field_limit = 0;  ///< end of the field's scale; 0: its largest number, rounded up
  std::string title;
  bool mesh = false;  ///< whether element edges are drawn
  double azimuth = -30, elevation = 30, zoom = 1;
  int up = 2;  ///< axis that points upwards, 0 (x) to 2 (z)
  /// Further positions of the nodes that the view has to hold: with the same ones, several pictures
  /// have the same scale and can be compared.
  std::vector<const Points*> also_in_view;
};

/// Parts of faces from those of nodes: that of all its nodes, Body where they differ.
std::vector<MeshPicture::Part> parts_of_faces(const ShellMesh& shells,
                                              const std::vector<MeshPicture::Part>& of_node);

/// Draws the pictures into one PNG, row by row, with titles as captions below them (above a single
/// one). Normals are smoothed where neighbouring faces differ by less than 30 degrees. The file
/// appears whole or not at all. To be called on the main thread; needs a display (require_display).
/// Throws InputError: no display, no picture, no column, a picture without faces or with lists of
/// the wrong length, a value out of its range, a file that cannot be written.
void draw_meshes(const std::filesystem::path& path, const std::vector<MeshPicture>& pictures,
                 int columns, const PictureSize& size = {});

/// The same in memory, for animations.
Image mesh_image(const std::vector<MeshPicture>& pictures, int columns,
                 const PictureSize& size = {});

}  // namespace batten
