// SPDX-License-Identifier: MPL-2.0
// Reads the free edges of the faces of a CAD file, with the tangent planes and curvatures of the
// faces along them, and finds the openings that they surround.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/neighbour_edge.h"

namespace batten {

/// A closed loop of free edges of the faces of a CAD file.
struct CadOpening {
  std::vector<std::string> lines;  ///< names of the edges, in order around the loop
  std::vector<std::string> faces;  ///< names of the faces beside the loop, without repetition
  double length = 0;               ///< length of the loop, model units
  Vec3 centre = Vec3::Zero();      ///< mean of points on the loop
  /// Total geodesic curvature of the loop on the faces, including the angles at its corners,
  /// degrees: 360 at the outer boundary of a flat sheet, -360 around a hole in it, 0 at the end of a
  /// tube. By the theorem of Gauss and Bonnet, it is 360 degrees times the Euler characteristic
  /// minus the integral of the Gaussian curvature, if the faces have no other boundary.
  double turning_deg = 0;
  int component = 0;  ///< number of the connected set of faces that has this loop, from 0
  /// True if the connected faces lie inside the loop rather than around it, as in a sheet: its
  /// turning_deg exceeds 320 or, if the faces have another loop below -180 (a hole), 180.
  bool outer_boundary = false;
};

/// The free edges of the faces of a CAD file.
struct CadNeighbours {
  std::vector<CharacterLine> lines;        ///< one per free edge, named as in read_cad_lines()
  std::vector<NeighbourCurve> neighbours;  ///< for each of `lines`, the face beside it
  std::vector<CadOpening> openings;        ///< closed loops of `lines`, longest first
  /// Names of free edges that belong to no closed loop.
  std::vector<std::string> open_lines;
  int faces = 0;    ///< number of faces, without those left out
  double size = 0;  ///< diagonal of the bounding box of all edges, model units
};

/// Selection of faces of a CAD file by their names, "face 1", "face 2" … in file order.
struct CadFaceSelection {
  std::vector<std::string> only;     ///< empty: all faces
  std::vector<std::string> without;  ///< faces that are left out, for example to be replaced
  bool includes(const std::string& face) const;
};

/// Reads the free edges of the selected faces: the edges with exactly one selected face, without
/// seams. Coincident edges of faces that share none, as in IGES files, are merged first. Each edge
/// has 400 samples of the tangent plane and curvature or, if it is closed, 1,600.
///
/// Throws InputError for a file that cannot be read (as read_cad_lines()), a file without faces, and
/// a name that is no face of the file. O(edges).
CadNeighbours read_cad_neighbours(const std::filesystem::path& file, double model_unit_in_metres,
                                  const CadFaceSelection& selection = {});

}  // namespace batten
