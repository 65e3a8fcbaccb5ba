// SPDX-License-Identifier: MPL-2.0
// Blends: a face between edges of given faces ([[neighbour]] with bridge = true and edges).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/neighbour_faces.h"
#include "batten/skinning/search/regions.h"

namespace batten {

/// An edge of a given face that a blend continues.
struct BlendEdge {
  std::string name;
  std::array<Vec3, 2> ends;  ///< points at its ends; equal for a closed edge
  /// Unit vectors in the tangent plane of the given face at these points, in which the sides of the
  /// blend leave it: the direction of the face's own side edge that ends there, if it is within 60
  /// degrees of the perpendicular to the edge, or else this perpendicular.
  std::array<Vec3, 2> across;
  std::vector<NeighbourSample> samples;  ///< the given face along the edge
};

/// The edge number `index` of given faces.
BlendEdge blend_edge(const NeighbourFaces& faces, int index);

/// A face between two chains of edges.
struct Blend {
  /// Curves between the chains: two sides and curves inside the face; none if the
  /// chains are closed.
  std::vector<CharacterLine> curves;
  RegionSpec region;
};

/// Connects two chains of edges. Open chains are connected by cubic curves: two sides between the ends
/// that are closest to each other, and curves inside the face, between points at equal fractions of the
/// lengths of the chains, not farther apart than half of the distance between the chains. They leave the
/// given faces in the directions BlendEdge::across and directions interpolated between these, with
/// derivatives of `tension` times the distance of their ends, so that larger values bulge more; 0: 1.
/// Throws InputError if the edges do not form two chains that are both open or both closed, and if there
/// is a tension for closed chains.
Blend blend_between(const std::vector<BlendEdge>& edges, double tension);

}  // namespace batten
