// Deformation by Laplacian vectors of the dual mesh that find their own directions.
#pragma once

#include <memory>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct DualLaplacianOptions {
  int max_iterations = 200;
  double tolerance = 1e-6;  ///< of the mesh's size: rounds end when no vertex moves by more
  /// Faces on the border have no Laplacian row, or the middle of a border edge stands in for the
  /// neighbour that is not there: measured, angles along free borders change by 2 to 7 % more then.
  enum class Border { Omitted, EdgeMidpoints } border = Border::Omitted;
  /// Length of the turned vectors: that of the original, or fitted together with the direction, as
  /// Au et al. re-estimate it: faces then grow and shrink freely.
  enum class Lengths { Original, Fitted } lengths = Lengths::Original;
  /// μ, how much faces resist to be stretched and sheared.
  double membrane = 1;
  double checkerboard_penalty =
      0.1;  ///< η, how much primal vertices resist to go to and fro; 0: not at all
};

/// The dual vertex of a face f of k corners is their mean d_f; its neighbours n_j are the dual
/// vertices across the k edges. The primal positions p are the unknowns: d = M p. Each face turns by
/// a rotation R_f of its own and should keep its Laplacian vector l_f and, weakly, its edges:
///
///     E = ½ Σ_f A_f | (Σ_j w_fj n_j - d_f - R_f l_f) / c_f |²                   Laplacian
///       + ½ Σ_f η/k A_f Σ_h | (h(p) - R_f h(p⁰)) / q_h |²                        primal
///       + ½ Σ_f μ_f A_f Σ_e |e - R_f e⁰|² / Σ_e |e⁰|²                            membrane
///
///     w_fj  Σ_j w_fj = 1, chosen so that l_f = Σ_j w_fj n_j⁰ - d_f⁰ stands upright on the plane of
///           the neighbours: l_f = h_f n_f without tangential part (of all such weights those nearest
///           to 1/k; 1/k where the neighbours are on one line)
///     c_f   mean of |n_j⁰ - d_f⁰|² / 4, so that |l_f| / c_f is a curvature (for three even
///           neighbours twice the mean of the principal ones)
///     h     for each neighbour its corners beyond the edge, less where the plane of the face has
///           them; for k > 3 also the k - 3 ways in which corners leave a plane. q_h: what a second
///           derivative of 1 makes of h, Frobenius norm
///     μ_f   μ (1/size² + κ̄² + κ_f²), κ_f² the squares of l_f/c_f and, with their weights, h(p⁰)/q_h;
///           κ̄ the mean of κ_f over the area
///
/// Rounds alternate the exact minimum over all R_f and over all p, so E never rises; one Cholesky
/// factor for all rounds and all edits. Differences from the paper: it takes the direction of the
/// turned vector from the neighbours' plane, which is no minimum of anything that was measured;
/// here R_f follows the edges of the face and the vectors together. And dual positions alone do not
/// determine primal ones: vertices that move by +1, -1 in turn leave every d_f where it is, and a
/// sheet that is compressed takes that way out. The membrane tells such modes apart, the primal
/// rows keep them down: on squares, 0.02 of an edge without them, 0.001 with η = 0.1, and edges
/// change by 18 % at most instead of 42 %. Where the surface bends the membrane keeps vectors from
/// leaning over. docs/theory/deformers.md has what was measured.
///
/// Solids that are twisted far are for ArapDeformer: of the section of a bar of length 6 this
/// one keeps 74 % at 180°, that one 94 %.
///
/// Where sheets meet, + ½ |R_f - R_g|² keeps the angles between their faces.
///
/// A patch that is lifted without a turn gives a slope whose faces have turned. First rotations: the
/// handles' turns, spread as logarithms that are not reduced. Handles and fixed vertices hold
/// exactly; a handle's scale moves its own vertices only. Cost: one factor of n unknowns at
/// construction; a round is one solve and O(faces), without allocation. Source: Au, Tai, Liu, Fu
/// 2006.
class DualLaplacianDeformer final : public IterativeDeformer {
 public:
  /// `faces`: polygons of three or more corners, wound alike; none: the mesh's triangles. Throws
  /// InputError (check() in deform_problem.h; a face with fewer than three corners, one out of range
  /// or there twice; an edge of more than two faces; options negative or not finite),
  /// NoSolutionError.
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
  /// R_f of every face after the last edit; with Lengths::Fitted times its scale.
  const std::vector<Mat3>& face_rotations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
