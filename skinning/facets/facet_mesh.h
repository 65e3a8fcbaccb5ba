// Inside of facets: a Delaunay mesh of a region in (u, v) that follows its lines.
#pragma once

#include <memory>
#include <vector>

#include "batten/skinning/facets/facet_line.h"
#include "batten/skinning/facets/facets.h"

namespace batten {

/// The part of a line between two neighbouring stops; it is one edge of the mesh.
struct ConstrainedEdge {
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
  std::vector<ConstrainedEdge> constrained_edges;
  std::vector<int> constrained_edge_of;         ///< of each edge; -1: none
  std::vector<std::vector<int>> edges_of_line;  ///< pieces of each line that are kept, in order

  /// Returns the image p(L) of a point of the mesh (facets.h), in (u, v).
  Vec2 map_point(const Location& where) const;
};

/// Meshes a region whose boundary is stated. `edge_length` 0 means that of mean_edge(). Edges on
/// lines are halved until no triangle at a curved one comes near to folding. Throws as
/// quadratic_elements().
FacetMesh facet_mesh(const SkinnedRegion& region, double edge_length,
                     const SubdivisionRequest& requested);

}  // namespace batten
