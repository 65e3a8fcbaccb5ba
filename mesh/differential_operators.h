// SPDX-License-Identifier: MPL-2.0
// Discrete differential operators on triangle meshes: cotangent Laplacian and mixed areas.
#pragma once

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Integrated cotangent Laplacian L_c of a mesh with n vertices, n×n; only the lower triangle of
/// the matrix is stored:
///
///     (L_c)_ij = -½ (cot α_ij + cot β_ij),   (L_c)_ii = ½ Σ_j (cot α_ij + cot β_ij)
///
/// α_ij and β_ij are the angles opposite to edge ij; a boundary edge has only α_ij. L_c is positive
/// semidefinite: qᵀ L_c q is the Dirichlet energy ∫ |∇q|² of a piecewise linear function q. Rows of
/// vertices without triangles are empty. A triangle of zero area gives entries that are not finite;
/// prepare() rejects such meshes. O(triangles). Reference: [PinkallPolthier1993].
///
/// The mean-curvature vector at vertex i with position p_i, normal n_i and mixed area A_i (see
/// mixed_areas()) is δ_i = (L_c p)_i / (2 A_i) = κ_i n_i. κ_i is the mean of the two principal
/// curvatures; on a sphere, n_i points away from the centre.
SparseMatrix cotangent_laplacian(const TriangleMesh& mesh);

/// Half the cotangents of the three corner angles of each triangle, 3 × number of triangles.
/// cotangent_laplacian() is assembled from these terms. O(triangles).
Eigen::Matrix3Xd half_cotangents(const TriangleMesh& mesh);

/// Cotangent weight ½ (cot α + cot β) of each edge, in the order of MeshTopology::edges(). α and β
/// are the angles opposite to the edge. A boundary edge has only α. The weight is the off-diagonal
/// entry of cotangent_laplacian(), with opposite sign. O(triangles).
std::vector<double> edge_cotangents(const TriangleMesh& mesh);

/// Mixed area of each of the n vertices, in model units². In each adjacent triangle, a vertex gets
/// the area of its Voronoi cell. In an obtuse triangle, the vertex at the obtuse angle gets half of
/// the triangle's area, the other two vertices a quarter each. The mixed areas sum to the area of
/// the mesh; those of vertices without triangles are 0. Reference: [Meyer2003].
VecX mixed_areas(const TriangleMesh& mesh);

}  // namespace batten
