// SPDX-License-Identifier: MPL-2.0
// Draws pictures of shell meshes, for example before and after a deformation, side by side.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/mesh/shell_mesh.h"

namespace batten {

/// Content and view of one picture of a mesh. The projection is parallel, and the axis `up` points
/// upwards.
struct MeshPicture {
  /// Role of a face in an edit, shown by its colour.
  enum class Part { Body, Feature, Handle, Fixed };

  const ShellMesh* shells = nullptr;
  Points points;                        ///< positions of the nodes, n×3
  std::vector<Part> parts;              ///< role of each face; empty: all faces are Body
  std::vector<std::vector<int>> lines;  ///< polylines to draw as tubes, as lists of node indices
  VecX field;  ///< non-negative value per node, shown by colours; empty: none
  std::string field_title;
  double field_limit = 0;  ///< upper end of the colour scale; 0: largest value, rounded up
  std::string title;
  bool mesh = false;  ///< true: draw the element edges
  double azimuth = -30, elevation = 30, zoom = 1;
  int up = 2;  ///< axis that points upwards: 0, 1, 2 for x, y, z
  /// Additional node positions (n×3 each) that must be visible in the picture. Pictures with the
  /// same list have the same scale and can be compared.
  std::vector<const Points*> also_in_view;
};

/// Converts roles per node to roles per face: the role that all nodes of the face have in common,
/// or Body if they differ.
std::vector<MeshPicture::Part> parts_of_faces(const ShellMesh& shells,
                                              const std::vector<MeshPicture::Part>& of_node);

/// Draws pictures of meshes into one PNG file, written atomically, with `columns` pictures per row.
/// Titles are captions below the pictures (above, if there is only one picture). Shading is smooth
/// across edges at which the normals of the faces differ by less than 30 degrees.
///
/// Call draw_meshes() on the main thread; it needs a display (see require_display()). Throws
/// InputError if there is no display, no picture or no column, if a picture has no faces, lists of
/// the wrong length or values out of range, or if the file cannot be written.
void draw_meshes(const std::filesystem::path& path, const std::vector<MeshPicture>& pictures,
                 int columns, const PictureSize& size = {});

/// Draws pictures of meshes like draw_meshes(), but into an image in memory, for animations.
Image mesh_image(const std::vector<MeshPicture>& pictures, int columns,
                 const PictureSize& size = {});

}  // namespace batten
