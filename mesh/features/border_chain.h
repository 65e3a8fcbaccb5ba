// The border of a set of triangles as chains of vertices.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct BorderChain {
  std::vector<int> vertices;  ///< each once in a closed chain that does not touch itself
  bool closed = true;         ///< open chains start and end on the mesh's own boundary
};

/// Edges between a triangle inside and one outside, linked to chains that have the outside on their
/// left, as boundary loops of MeshTopology have the surface. Edges of the mesh's own boundary are
/// not part of it. `inside` holds a flag for each triangle. At a vertex where two parts of the set
/// touch, chains go on along the part they came along, so that every chain belongs to one part.
/// Closed chains start at their lowest vertex; chains are sorted. O(triangles).
std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside);

}  // namespace batten
