// Where a mesh draws the eye, and regions grown from there.
#pragma once

#include <vector>

#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Mesh saliency of every vertex, 0 … 1:
///
///     C         mean curvature, δ_i · n_i (mesh/differential_operators.h; n_i the vertex normal)
///     G(C, σ)   mean of C over the vertices within 2σ, weights A_j exp(-|p_j - p_i|² / 2σ²)
///     S_σ       |G(C, σ) - G(C, 2σ)|,   σ = 2ε, 3ε, 4ε, 5ε, 6ε,   ε = 0.003 of the box diagonal
///     S         Σ_σ N(S_σ), divided by its largest value
///
/// N: the map is divided by its maximum and multiplied by (1 - m̄)², m̄ the mean of its other local
/// maxima, so that maps with a few high peaks count for more than evenly busy ones. The areas A_j
/// (the paper has none) keep finer parts of a mesh from counting more. 0 everywhere on what bends
/// nowhere (|C| below 1e-9 over the size).
///
/// O(n · vertices within 0.072 of the diagonal), in parallel: 10 s of one core for 100,000 vertices. Throws InputError for a mesh without
/// triangles. Source: Lee, Varshney, Jacobs 2005; Itti, Koch, Niebur 1998 (N).
VecX mesh_saliency(const TriangleMesh& mesh);

/// The vertices that paths along edges reach from `picked` without meeting a saliency under
/// `threshold`, ascending. Throws InputError: not one number a vertex, a vertex out of range, or one
/// that is itself under the threshold (the message has its saliency).
std::vector<int> grown_region(const TriangleMesh& mesh, const VecX& saliency, int picked,
                              double threshold);

}  // namespace batten
