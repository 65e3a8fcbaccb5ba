// Pictures of shell meshes, for example before and after a deformation, side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// One picture of a mesh. As in PictureScene, the projection is parallel and z points upwards.
struct MeshPicture {
  /// Role of a face, shown by its colour.
  enum class Part { Body, Feature, Handle, Fixed };

  const ShellMesh* shells = nullptr;
  Points points;                        ///< positions of the nodes, n×3
  std::vector<Part> parts;              ///< role of each face, shown by its colour; empty: all Body
  std::vector<std::vector<int>> lines;  ///< lists of nodes, drawn as tubes
  VecX field;                           ///< value ≥ 0 per node, shown as colour; empty: none
  std::string field_title;
  double field_limit = 0;  ///< upper end of the field's scale; 0: its maximum, rounded up
  std::string title;
  bool mesh = false;  ///< true: draw element edges
  double azimuth = -30, elevation = 30, zoom = 1;
  int up = 2;  ///< axis that points upwards, 0 (x) to 2 (z)
  /// Further node positions that must be in view. Pictures with the same list have the same scale
  /// and can be compared.
  std::vector<const Points*> also_in_view;
};

/// Converts parts per node to parts per face: the common part of the face's nodes, Body if they
/// differ.
std::vector<MeshPicture::Part> parts_of_faces(const ShellMesh& shells,
                                              const std::vector<MeshPicture::Part>& of_node);

/// Draws the pictures into one PNG, row by row, written atomically. Titles are captions below the
/// pictures (above, if there is only one). Normals are smoothed if neighbouring faces differ by
/// less than 30 degrees.
///
/// Call it on the main thread; it needs a display (require_display). Throws InputError if there is
/// no display, no picture or no column, or if a picture has no faces. Also throws it for lists of
/// the wrong length, values out of range, or a file that cannot be written.
void draw_meshes(const std::filesystem::path& path, const std::vector<MeshPicture>& pictures,
                 int columns, const PictureSize& size = {});

/// Draws the pictures as draw_meshes() does, into an image in memory instead of a file: for example
/// one frame of an animation.
Image mesh_image(const std::vector<MeshPicture>& pictures, int columns,
                 const PictureSize& size = {});

}  // namespace batten
