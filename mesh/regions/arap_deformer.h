// SPDX-License-Identifier: MPL-2.0
// As-rigid-as-possible (ARAP) deformation with smoothed rotations, for large edits.
#pragma once

#include <vector>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of ArapDeformer.
struct ArapOptions {
  int max_iterations = 300;  ///< maximum number of iterations, at least 1
  /// The iteration stops when the largest displacement of a vertex in an iteration, relative to the
  /// mesh size, is below this value.
  double tolerance = 1e-6;
  /// Penalty α ≥ 0 on differences between the rotations of neighbouring vertices. It acts like the
  /// bending stiffness of a shell of thickness √(α · area of the mesh). With α = 0, only the
  /// bending stiffness of the discrete ARAP energy remains.
  double smoothing = 3e-4;
};

/// As-rigid-as-possible deformation (spokes and rims) with rotation smoothing. Each vertex i has a
/// rotation R_i. The energy penalises deviations of each triangle from the undeformed triangle,
/// rotated by the rotations of its corners:
///
///     E = ½ Σ_t A_t ⅓ Σ_{i of t} |∇p - R_i ∇p⁰|²_t  +  ½ α A Σ_{edges ij} w_ij |R_i - R_j|²
///
/// A_t and ∇ are the area and gradient on the undeformed triangle t, p⁰ and p the undeformed and
/// deformed positions, A is the area of the mesh, and α is ArapOptions::smoothing. The first sum is
/// the spokes-and-rims energy with cotangent weights, Σ ½cot |e - R_i e⁰|² over the three edges of
/// each triangle at i. In terms of gradients it is a sum of squares, so negative cotangents of
/// obtuse triangles do no harm. w_ij are the edge_cotangents() of mesh/differential_operators.h,
/// with negative values replaced by 0.
///
/// Local/global iteration: the local step minimises the energy exactly over the rotations R_i (one
/// colour class of vertices after the other, nearest rotations of 3×3 matrices), the global step
/// over all positions p (one linear solve). The energy never increases. The matrix of the global
/// step is the cotangent Laplacian, which is factored once for all iterations and edits. The
/// initial rotations interpolate the rotation vectors of the handles harmonically. Rotation vectors
/// may exceed a full turn, so a bar rotated by 360° at one end is twisted. There is no volume
/// constraint; closed surfaces keep their volume only approximately.
///
/// Handles and fixed vertices are satisfied exactly. The rotation R_i of such a vertex is that of
/// its handle (fixed: the identity) unless a triangle at the vertex is fixed or moved as a whole,
/// which determines the rotation. A single row of vertices therefore clamps the surface, too. The
/// scale of a handle affects only its own vertices. Cost: one factorization with n unknowns at
/// construction; one solve and O(triangles) per iteration, without allocation. References:
/// [SorkineAlexa2007]; [Chao2010] (spokes and rims); [LeviGotsman2015] (smoothing).
class ArapDeformer final : public IterativeDeformer {
 public:
  /// Sets up and factors the linear system. `fixed`, `handles`: vertices as in DeformProblem.
  /// Throws InputError if check() rejects them (deform_problem.h), a triangle has zero area, or an
  /// option is negative or not finite, and NoSolutionError if the factorization fails.
  ArapDeformer(const TriangleMesh& mesh, std::vector<int> fixed, std::vector<Handle> handles,
               const ArapOptions& options = {});
  /// Rotation of every node after the last edit. The coincident vertices of a node have a common
  /// rotation, which preserves the angles between the manifold patches that meet there.
  const std::vector<Mat3>& vertex_rotations() const { return rotations(); }
};

}  // namespace batten
