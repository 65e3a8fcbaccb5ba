// SPDX-License-Identifier: MPL-2.0
// The free edges of given faces or of a given mesh, and the openings that they surround.
#pragma once

#include <string>
#include <vector>

#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/neighbour_edge.h"

namespace batten {

/// A closed loop of free edges of given faces.
struct NeighbourOpening {
  std::vector<std::string> lines;  ///< names of the edges, in order around the loop
  std::vector<std::string> faces;  ///< names of the faces beside the loop, without repetition
  double length = 0;               ///< length of the loop, model units
  Vec3 centre = Vec3::Zero();      ///< mean of points on the loop
  /// Total geodesic curvature of the loop on the faces, including the angles at its corners,
  /// degrees: 360 at the outer boundary of a flat sheet, -360 around a hole in it, 0 at the end of a
  /// tube. By the theorem of Gauss and Bonnet, it is 360 degrees times the Euler characteristic
  /// minus the integral of the Gaussian curvature, if the faces have no other boundary.
  double turning_deg = 0;
  /// Mean length of the edges of a mesh on the loop, model units; 0: the faces are no mesh.
  double edge_length = 0;
  int component = 0;  ///< number of the connected set of faces that has this loop, from 0
  /// True if the connected faces lie inside the loop rather than around it, as in a sheet
  /// (find_outer_boundaries()).
  bool outer_boundary = false;
};

/// The free edges of given faces.
struct NeighbourFaces {
  std::vector<CharacterLine> lines;        ///< one per free edge
  std::vector<NeighbourCurve> neighbours;  ///< for each of `lines`, the face beside it
  std::vector<NeighbourOpening> openings;  ///< closed loops of `lines`, longest first
  /// Names of free edges that belong to no closed loop.
  std::vector<std::string> open_lines;
  int faces = 0;  ///< number of faces
  /// Largest distance of `lines` from the faces that is their accuracy, as of noisy meshes, model
  /// units; 0: the lines are exact.
  double accuracy = 0;
  double size = 0;  ///< diagonal of the bounding box, model units
};

/// Sets NeighbourOpening::outer_boundary: true for loops with a turning_deg above 320 or, if the same
/// connected faces have another loop below -180 (a hole), above 180.
void find_outer_boundaries(std::vector<NeighbourOpening>& openings);

}  // namespace batten
