// Discrete differential operators of triangle meshes.
#pragma once

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Integrated cotangent Laplacian L_c, n×n, lower triangle:
///
///     (L_c)_ij = -½ (cot α_ij + cot β_ij),   (L_c)_ii = ½ Σ_j (cot α_ij + cot β_ij)
///
/// α_ij, β_ij the angles opposite to edge ij; a boundary edge has one. Positive semidefinite:
/// qᵀ L_c q is the Dirichlet energy ∫ |∇q|² of a piecewise linear q. Rows of vertices without
/// triangles are empty. A triangle of no area gives numbers that are not finite (prepare() refuses
/// it). O(triangles).
///
/// The mean-curvature vector of the mesh at p_i is δ_i = (L_c p)_i / (2 A_i) = κ_i n_i, κ_i the
/// mean of the two principal curvatures and n_i away from the centre of a sphere.
SparseMatrix cotangent_laplacian(const TriangleMesh& mesh);

/// ½ cot of the angles at the three corners of each triangle, what L_c is summed from: 3×triangles.
Eigen::Matrix3Xd half_cotangents(const TriangleMesh& mesh);

/// ½ (cot α + cot β) of each edge of the topology: -(L_c)_ij.
std::vector<double> edge_cotangents(const TriangleMesh& mesh);

/// Mixed areas A_i, n: the Voronoi part of each triangle, or a half (at the obtuse corner) and
/// quarters of it where it is obtuse, so that they sum to the area of the mesh. 0 for vertices
/// without triangles. Source: Meyer, Desbrun, Schröder, Barr 2003.
VecX mixed_areas(const TriangleMesh& mesh);

}  // namespace batten
