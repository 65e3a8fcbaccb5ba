// Fill-reducing orders of a surface's dofs: one from its geometry, and what another needs.
#pragma once

#include <array>
#include <vector>

#include "batten/fem/parametric_mesh.h"

namespace batten {

/// Nested dissection: the triangles are halved by their centres across the longer side of their
/// box, again and again; the dofs that both halves touch come last, those of the halves before
/// them, each ordered the same way. O(triangles · log triangles), far cheaper than finding an order
/// from the matrix, and with less fill on large meshes. Result: all dofs, the first to eliminate
/// first.
std::vector<int> nested_dissection_order(const ParametricMesh& mesh);

/// Of each dof its vertex, twice, or the two ends of its edge: what vertex_ordering needs.
std::vector<std::array<int, 2>> dof_vertices(const ParametricMesh& mesh);

}  // namespace batten
