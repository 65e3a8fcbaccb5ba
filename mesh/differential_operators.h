// Discrete differential operators on triangle meshes: cotangent Laplacian and mixed areas.
#pragma once

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Integrated cotangent Laplacian L_c, n×n; only the lower triangle is stored:
///
///     (L_c)_ij = -½ (cot α_ij + cot β_ij),   (L_c)_ii = ½ Σ_j (cot α_ij + cot β_ij)
///
/// α_ij and β_ij are the angles opposite to edge ij; a boundary edge has only one. L_c is positive
/// semidefinite: qᵀ L_c q is the Dirichlet energy ∫ |∇q|² of a piecewise linear q. Rows of vertices
/// without triangles are empty. A triangle without area gives entries that are not finite;
/// prepare() rejects such meshes. O(triangles).
///
/// The mean-curvature vector at p_i is δ_i = (L_c p)_i / (2 A_i) = κ_i n_i. κ_i is the mean of the
/// two principal curvatures; on a sphere, n_i points away from the centre.
SparseMatrix cotangent_laplacian(const TriangleMesh& mesh);

/// ½ cot of the angles at the three corners of each triangle, 3×triangles. L_c is assembled from
/// them.
Eigen::Matrix3Xd half_cotangents(const TriangleMesh& mesh);

/// Cotangent weights ½ (cot α + cot β) of the edges of the topology, equal to -(L_c)_ij.
std::vector<double> edge_cotangents(const TriangleMesh& mesh);

/// Mixed areas A_i of the vertices, size n. Each corner gets its Voronoi area within the triangle.
/// In an obtuse triangle the obtuse corner gets half of the area and the other two a quarter each.
/// The areas sum to the area of the mesh; vertices without triangles have 0. Source: [Meyer2003].
VecX mixed_areas(const TriangleMesh& mesh);

}  // namespace batten
