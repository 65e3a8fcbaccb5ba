// Deformation with Laplacian vectors of the dual mesh, whose rotations are part of the solution.
#pragma once

#include <memory>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of DualLaplacianDeformer.
struct DualLaplacianOptions {
  int max_iterations = 200;  ///< at least 1
  /// The iteration stops when no vertex moves by more, relative to the mesh size.
  double tolerance = 1e-6;
  /// Treatment of boundary faces. Omitted: they have no Laplacian row. EdgeMidpoints: the midpoint
  /// of a boundary edge replaces the missing neighbour. Measured: EdgeMidpoints increases the
  /// change of angles along free boundaries by 2 to 7 %.
  enum class Border { Omitted, EdgeMidpoints } border = Border::Omitted;
  /// Length of the rotated Laplacian vectors. Original: that of the undeformed mesh. Fitted:
  /// estimated together with the direction, as Au et al. do; faces then grow and shrink freely.
  enum class Lengths { Original, Fitted } lengths = Lengths::Original;
  /// μ > 0: membrane stiffness, the resistance of faces to stretch and shear.
  double membrane = 1;
  double checkerboard_penalty =
      0.1;  ///< η ≥ 0: penalty on the checkerboard mode, which leaves the dual Laplacian unchanged;
            ///< 0: none
};

/// Dual Laplacian deformation after Au et al. The dual vertex of a face f with k corners is their
/// centroid d_f; its neighbours n_j are the dual vertices across the k edges. The unknowns are the
/// primal positions p, with d = M p. Each face has its own rotation R_f and should keep its
/// Laplacian vector l_f and, weakly, its edges:
///
///     E = ½ Σ_f A_f | (Σ_j w_fj n_j - d_f - R_f l_f) / c_f |²                   Laplacian
///       + ½ Σ_f η/k A_f Σ_h | (h(p) - R_f h(p⁰)) / q_h |²                        primal
///       + ½ Σ_f μ_f A_f Σ_e |e - R_f e⁰|² / Σ_e |e⁰|²                            membrane
///
///     w_fj  weights with Σ_j w_fj = 1 such that l_f = Σ_j w_fj n_j⁰ - d_f⁰ is normal to the plane
///           of the neighbours: l_f = h_f n_f without tangential part. Of all such weights those
///           nearest to 1/k; exactly 1/k if the neighbours are collinear
///     c_f   mean of |n_j⁰ - d_f⁰|² / 4, so that |l_f| / c_f is a curvature (for three evenly
///           spaced neighbours twice the mean of the principal curvatures)
///     h     for each neighbour: the centroid of its corners beyond the common edge, minus the
///           value extrapolated from the corners of f. For k > 3 also the k - 3 modes in which the
///           corners leave a plane. q_h: value of h for unit second derivatives (Frobenius norm)
///     μ_f   μ (1/size² + κ̄² + κ_f²); κ_f² sums the squares of l_f/c_f and, with their weights,
///           of h(p⁰)/q_h; κ̄ is the area-weighted mean of κ_f
///
/// Local/global iteration: exact minimum over all R_f, then over all p, so E never increases. One
/// Cholesky factorization serves all iterations and edits.
///
/// Differences from the paper: the paper takes the direction of the rotated vector from the plane
/// of the neighbours, which does not minimise any energy. Here R_f is fitted to the edges of the
/// face and the vectors together. Also, dual positions alone do not determine primal ones: the
/// checkerboard mode, in which vertices move by +1 and -1 alternately, leaves all d_f unchanged,
/// and a compressed surface buckles into it. The membrane term makes such modes distinguishable,
/// and the primal term keeps them small. Measured on squares: amplitude 0.02 of an edge without the
/// primal term, 0.001 with η = 0.1; edges change by at most 18 % instead of 42 %. Where the surface
/// bends, the membrane term keeps the vectors from tilting. See docs/theory/deformers.md for the
/// measurements.
///
/// For strongly twisted solids use ArapDeformer: at a twist of 180°, a bar of length 6 keeps 74 %
/// of its cross-section with this class and 94 % with ArapDeformer.
///
/// At non-manifold edges, the additional term ½ |R_f - R_g|² preserves the angles between faces of
/// different patches.
///
/// A patch that is lifted without rotation produces a slope whose faces have rotated. The initial
/// rotations are those of the handles, interpolated as logarithms that are not reduced. Handles and
/// fixed vertices are satisfied exactly; the scale of a handle affects only its own vertices. Cost:
/// one factorization with n unknowns at construction; each iteration is one solve plus O(faces),
/// without allocation. Source: [Au2006].
class DualLaplacianDeformer final : public IterativeDeformer {
 public:
  /// `faces`: polygons with three or more corners, consistently oriented; if empty, the triangles
  /// of the mesh. Throws InputError (see check() in deform_problem.h; a face with fewer than three
  /// corners, with a corner out of range or repeated; an edge with more than two faces; options
  /// negative or not finite) or NoSolutionError (the factorization fails).
  DualLaplacianDeformer(const TriangleMesh& mesh, std::vector<std::vector<int>> faces,
                        std::vector<int> fixed, std::vector<Handle> handles,
                        const DualLaplacianOptions& options = {});
  ~DualLaplacianDeformer() override;
  DualLaplacianDeformer(DualLaplacianDeformer&&) noexcept;
  DualLaplacianDeformer& operator=(DualLaplacianDeformer&&) noexcept;

  const Points& deform(std::span<const HandleTransform> moves) override;
  const Points& deform(std::span<const HandleTransform> moves, const Points& guess) override;
  const Points& positions() const override;
  const IterationReport& report() const override;
  /// Rotation R_f of every face after the last edit; with Lengths::Fitted multiplied by its scale.
  const std::vector<Mat3>& face_rotations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
