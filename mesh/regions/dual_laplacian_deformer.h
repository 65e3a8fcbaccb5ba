// Deformation by Laplacian vectors of the dual mesh that find their own directions.
#pragma once

#include <memory>

#include "batten/mesh/regions/deform_estimate.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct DualLaplacianOptions {
  int most_rounds = 100;
  double tolerance = 1e-6;  ///< of the mesh's size: rounds end when no vertex moves by more
  /// Faces on the border: the middle of a border edge stands in for the neighbour that is not there,
  /// or the face has no Laplacian row.
  enum class Border { EdgeMiddles, LeftOut } border = Border::EdgeMiddles;
  /// Length of the turned vectors: that of the original, or fitted together with the direction, as
  /// Au et al. re-estimate it: faces then grow and shrink freely.
  enum class Lengths { Original, Fitted } lengths = Lengths::Original;
  /// μ, how much faces resist to be stretched and sheared.
  double membrane = 1;
};

/// The dual vertex of a face f of k corners is their mean d_f; its neighbours n_j are the dual
/// vertices across the k edges. The primal positions p are the unknowns: d = M p. Each face turns by
/// a rotation R_f of its own and should keep its Laplacian vector l_f and, weakly, its edges:
///
///     E = ½ Σ_f A_f | (Σ_j w_fj n_j - d_f - R_f l_f) / c_f |²
///       + ½ Σ_f μ_f A_f Σ_e |e - R_f e⁰|² / Σ_e |e⁰|²
///
///     w_fj  Σ_j w_fj = 1, chosen so that l_f = Σ_j w_fj n_j⁰ - d_f⁰ stands upright on the plane of
///           the neighbours: l_f = h_f n_f without tangential part (of all such weights those nearest
///           to 1/k; 1/k where the neighbours are on one line)
///     c_f   mean of |n_j⁰ - d_f⁰|² / 4, so that |l_f| / c_f is a curvature (for three even
///           neighbours twice the mean of the principal ones)
///     μ_f   μ (1/size² + |l_f|² / c_f²), size the mesh's
///
/// Rounds alternate the exact minimum over all R_f and over all p, so E never rises; one Cholesky
/// factor for all rounds and all edits. Differences from the paper: it takes the direction of the
/// turned vector from the neighbours' plane, which is no minimum of anything that was measured;
/// here R_f follows the edges of the face and the vector together. And dual positions alone do not
/// determine primal ones (moving vertices by +1, -1 in turn leaves every d_f of a quad mesh): the
/// second sum does. Where a surface is flat it only has to tell such modes apart, where it bends it
/// keeps the vector from leaning over. What was measured: docs/theory/deformers.md.
///
/// A patch that is lifted without a turn gives a slope whose faces have turned. First rotations: the
/// handles' turns, spread as logarithms that are not reduced. Handles and fixed vertices hold
/// exactly; a handle's scale moves its own vertices only. Cost: one factor of n unknowns at
/// construction; a round is one solve and O(faces), without allocation. Source: Au, Tai, Liu, Fu
/// 2006.
class DualLaplacianDeformer final : public DeformEstimate {
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

  const Points& deform(std::span<const HandleMove> moves) override;
  const Points& deform(std::span<const HandleMove> moves, const Points& guess) override;
  const Points& positions() const override;
  const EstimateReport& report() const override;
  /// R_f of every face after the last edit; with Lengths::Fitted times its scale.
  const std::vector<Mat3>& face_turns() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
