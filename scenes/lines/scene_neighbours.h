// SPDX-License-Identifier: MPL-2.0
// The given faces of a scene ([[neighbour]]): their edges, and the openings between them that the
// scene fills.
#pragma once

#include <string>
#include <vector>

#include "batten/io/scene/scene.h"
#include "batten/scenes/lines/blend.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/neighbour_edge.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// What the [[neighbour]] tables of a scene add to its model.
struct SceneNeighbours {
  /// The given faces along their free edges; of a half model with their mirror images.
  std::vector<NeighbourCurve> neighbours;
  /// The edges of the openings that are filled.
  std::vector<CharacterLine> lines;
  /// One face for each of these openings; none if the scene has outline curves of its own, which
  /// may divide the openings.
  std::vector<RegionSpec> regions;
  std::vector<BlendEdge> blend;  ///< the edges that a bridge connects
  std::string openings;          ///< description of the openings for messages
  double accuracy = 0;           ///< the largest NeighbourFaces::accuracy of these lines
};

/// True if the scene has outline curves of its own.
bool has_outlines(const Scene& scene);

/// True if a face connects edges of given faces, rather than whole openings.
bool has_blend(const Scene& scene);

/// Reads the given faces of a scene. The openings that are filled are those that the scene selects
/// or, by default, all loops of free edges that are no outer boundary
/// (NeighbourOpening::outer_boundary). Without a statement in the scene, openings are filled only if
/// the scene has no outline curves.
///
/// Throws InputError, with the location in the scene, for a file that cannot be read, for faces
/// without free edges, for a number of an opening that does not exist, and if there is nothing to
/// fill; the message lists the openings.
SceneNeighbours read_neighbours(const Scene& scene);

}  // namespace batten
