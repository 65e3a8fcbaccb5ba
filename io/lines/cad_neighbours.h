// SPDX-License-Identifier: MPL-2.0
// Reads the free edges of the faces of a CAD file, with the tangent planes and curvatures of the
// faces along them, and finds the openings that they surround.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/skinning/model/neighbour_faces.h"

namespace batten {

/// Selection of faces of a CAD file by their names, "face 1", "face 2" … in file order.
struct CadFaceSelection {
  std::vector<std::string> only;     ///< empty: all faces
  std::vector<std::string> without;  ///< faces that are left out, for example to be replaced
  bool includes(const std::string& face) const;
};

/// Reads the free edges of the selected faces: the edges with exactly one selected face, without
/// seams. Coincident edges of faces that share none, as in IGES files, are merged first. Each edge
/// has 400 samples of the tangent plane and curvature or, if it is closed, 1,600. Edges are named as in
/// read_cad_lines().
///
/// Throws InputError for a file that cannot be read (as read_cad_lines()), a file without faces, and
/// a name that is no face of the file. O(edges).
NeighbourFaces read_cad_neighbours(const std::filesystem::path& file, double model_unit_in_metres,
                                   const CadFaceSelection& selection = {});

}  // namespace batten
