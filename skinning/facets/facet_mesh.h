// Inside of facets: a Delaunay mesh of a region in (u, v) that follows its lines.
#pragma once

#include <memory>
#include <vector>

#include "batten/skinning/facets/facet_lines.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

/// The part of a line between two neighbouring stops: one edge of the mesh.
struct FacetPiece {
  int line;
  double t0, t1;
  int a, b;
  bool curved;
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();  ///< its ends, where the line has them
};

struct FacetMesh {
  std::shared_ptr<const ParametricMesh> mesh;
  std::vector<FacetLine> lines;
  std::vector<FacetPiece> pieces;
  std::vector<int> piece_of_edge;             ///< or -1
  std::vector<std::vector<int>> piece_lists;  ///< of each line, in its order, those that are kept

  /// The image of a point of the mesh: facets.h.
  Vec2 image(const Location& where) const;
};

/// Meshes a region with a stated boundary. `edge_length` 0: mean_edge(). Edges are halved until no
/// triangle at a curved one comes near to folding. Throws as quadratic_facets().
FacetMesh facet_mesh(const SkinnedRegion& region, double edge_length, const LineStops& asked);

}  // namespace batten
