// Inside of facets: a Delaunay mesh of a region in (u, v) that follows its lines.
#pragma once

#include <memory>
#include <vector>

#include "batten/skinning/facets/facet_lines.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

/// The part of a line between two neighbouring stops; it is one edge of the mesh.
struct FacetPiece {
  int line;
  double t0, t1;
  int a, b;
  bool curved;
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();  ///< the line's points at t0, t1
};

/// The mesh, and where the lines lie in it.
struct FacetMesh {
  std::shared_ptr<const ParametricMesh> mesh;
  std::vector<FacetLine> lines;
  std::vector<FacetPiece> pieces;
  std::vector<int> piece_of_edge;             ///< of each edge; -1: none
  std::vector<std::vector<int>> piece_lists;  ///< pieces of each line that are kept, in order

  /// Returns the image p(L) of a point of the mesh (facets.h), in (u, v).
  Vec2 image(const Location& where) const;
};

/// Meshes a region whose boundary is stated. `edge_length` 0 means that of mean_edge(). Edges on
/// lines are halved until no triangle at a curved one comes near to folding. Throws as
/// quadratic_facets().
FacetMesh facet_mesh(const SkinnedRegion& region, double edge_length, const LineStops& asked);

}  // namespace batten
