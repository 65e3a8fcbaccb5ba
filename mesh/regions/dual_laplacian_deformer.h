// SPDX-License-Identifier: MPL-2.0
// Mesh deformation by rotated Laplacian vectors of the dual mesh; the rotations are unknowns.
#pragma once

#include <vector>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of DualLaplacianDeformer.
struct DualLaplacianOptions {
  int max_iterations = 200;  ///< maximum number of iterations, at least 1
  /// The iteration stops when the largest displacement of a vertex in an iteration, relative to the
  /// mesh size, is below this value.
  double tolerance = 1e-6;
  /// Treatment of faces at the mesh boundary. Omitted: boundary faces have no Laplacian term.
  /// EdgeMidpoints: the midpoint of a boundary edge replaces the missing neighbour. In
  /// measurements, EdgeMidpoints increased the change of angles along free boundaries by 2 to 7 %.
  enum class Border { Omitted, EdgeMidpoints } border = Border::Omitted;
  /// Length of the rotated Laplacian vectors of the faces. Original: the length in the undeformed
  /// mesh. Fitted: the length is an unknown, like the direction, as in [Au2006], so that faces grow
  /// and shrink freely.
  enum class Lengths { Original, Fitted } lengths = Lengths::Original;
  /// Membrane stiffness μ > 0: the resistance of faces to stretch and shear. A flat mesh stretches
  /// and bends like a plate of thickness √(12/μ) times the mesh size: 4 % by default. Stiffer
  /// membranes wrinkle: of a twisted box they buckle the walls.
  double membrane = 7000;
  /// Poisson's ratio ν of the bending energy, 0 to 1. With ν = 1, the energy is that of the dual
  /// Laplacian alone, which is free in two modes: a bent sheet curls across (anticlastic bending),
  /// and the vertices of squares move alternately up and down (checkerboard mode).
  double poisson_ratio = 0.02;
};

/// Dual Laplacian deformation [Au2006]. The dual vertex d_f of a face f is the centroid of its k
/// corners. The neighbours n_j of d_f are the dual vertices of the faces across the k edges. The
/// unknowns are the vertex positions p (primal positions) and one rotation R_f per face. The energy
/// penalises deviations from the rotated Laplacian vectors l_f, from the rotated second differences
/// h of the primal positions, and from the rotated edges:
///
///     E = ½ Σ_f ν A_f | (Σ_j w_fj n_j - d_f - R_f l_f) / c_f |²                 Laplacian
///       + ½ Σ_f (1-ν) 2/k A_f Σ_h | (h(p) - R_f h(p⁰)) / q_h |²                 primal
///       + ½ Σ_f μ_f A_f Σ_e |e - R_f e⁰|² / Σ_e |e⁰|²                           membrane
///       + ½ Σ_vu A_vu | (p_u - p_v - R_v (p_u⁰ - p_v⁰)) 2/|p_u⁰ - p_v⁰|² |²     clamped edges
///
///     w_fj  weights with Σ_j w_fj = 1 such that l_f = Σ_j w_fj n_j⁰ - d_f⁰ is normal to the plane
///           of the neighbours, without tangential part. Of all such weights, those nearest to 1/k
///           are taken; exactly 1/k if the neighbours are collinear
///     c_f   mean of |n_j⁰ - d_f⁰|² / 4, so that |l_f| / c_f is a curvature (for three evenly
///           spaced neighbours twice the mean of the principal curvatures)
///     h     for each neighbour face: the centroid of its corners beyond the common edge, minus the
///           value extrapolated from the corners of f. For k > 3 also the k - 3 modes in which the
///           corners leave a plane. q_h: value of h for unit second derivatives (Frobenius norm)
///     μ_f   μ/size² + κ̄² + κ_f²; κ_f² is the sum of the squares of l_f/c_f and of h(p⁰)/q_h
///           (with the weights of E); κ̄ is the area-weighted mean of κ_f; size: mesh size
///     A_f   area of face f; e: edge vectors of f; p⁰, n⁰, d⁰, e⁰: values of the undeformed mesh
///     vu    edges from fixed vertices and vertices of handles v, which belong to no face that is
///           fixed or moved as a whole, to free vertices u. R_v: rotation of the handle, or the
///           identity. A_vu: a quarter of the area of the faces at the edge
///
/// The first two terms are the bending energy of a plate with Poisson's ratio ν, the Frobenius norm
/// of the curvature for ν = 0. By the clamped edges, a single row of vertices prescribes the
/// rotation of the surface, too: the difference of the slopes at the middle and at the end of an
/// edge, divided by half of its length, is a curvature.
///
/// Each local/global iteration minimises E exactly over all R_f, then over all p, so E never
/// increases. One Cholesky factorization serves all iterations and edits.
///
/// Differences from [Au2006]: the paper takes the direction of the rotated vector from the plane of
/// the neighbours, which does not minimise any energy. Here R_f is fitted to the edges of the face
/// and the Laplacian vector together. Furthermore, dual positions do not determine the primal
/// positions: the checkerboard mode, in which vertices move by +1 and -1 alternately, leaves all
/// d_f unchanged, and a compressed surface buckles into this mode. The membrane term makes such
/// modes unique, and the primal term keeps their amplitude small. The Laplacian alone is also the
/// bending energy of a plate with ν = 1: a plate of 400 × 200 that is bent to the radius
/// 500 by its last row of vertices deviates from the cylinder by 17 (μ = 1), because it curls
/// across; with the default values by 0.19. If the surface bends, the membrane term prevents the
/// Laplacian vectors from tilting. The measurements are in docs/theory/deformers.md.
///
/// For strongly twisted solids use ArapDeformer: at a twist of 180°, a bar of length 6 keeps 86 %
/// of its cross-section with this class and 93 % with ArapDeformer.
///
/// At non-manifold edges, the additional term ½ |R_f - R_g|² preserves the angles between faces of
/// different patches.
///
/// Faces also rotate if a handle is only translated. The initial rotations interpolate the rotation
/// vectors of the handles, which may exceed a full turn. Handles and fixed vertices are satisfied
/// exactly; the scale of a handle affects only its own vertices. Cost: one factorization with n
/// unknowns at construction; one solve and O(faces) per iteration, without allocation.
class DualLaplacianDeformer final : public IterativeDeformer {
 public:
  /// Sets up and factors the linear system. `faces`: polygons with three or more corners,
  /// consistently oriented; empty: the triangles of the mesh. `fixed`, `handles`: vertices as in
  /// DeformProblem. Throws InputError if check() rejects them (deform_problem.h), a face has fewer
  /// than three corners, a corner is repeated or out of range, an edge has more than two faces, or
  /// an option is negative or not finite. Throws NoSolutionError if the factorization fails.
  DualLaplacianDeformer(const TriangleMesh& mesh, std::vector<std::vector<int>> faces,
                        std::vector<int> fixed, std::vector<Handle> handles,
                        const DualLaplacianOptions& options = {});
  /// Rotation of every face after the last edit; with Lengths::Fitted, each rotation is multiplied
  /// by the fitted scale of the face. Behind them, the vector contains the rotations that are
  /// prescribed at vertices of clamped edges.
  const std::vector<Mat3>& face_rotations() const { return rotations(); }
};

}  // namespace batten
