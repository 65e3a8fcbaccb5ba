// Large edits: a shape as rigid as possible piece by piece.
#pragma once

#include <memory>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

struct ArapOptions {
  int max_iterations = 300;
  double tolerance = 1e-6;  ///< of the mesh's size: rounds end when no vertex moves by more
  /// α: how much neighbouring rotations resist to differ. It acts like a bending stiffness of the
  /// thickness √(α · area); 0 leaves the surface without any but its own edges'.
  double smoothing = 0.001;
};

/// Each vertex has a rotation R_i of its own, and each triangle should be its original turned by the
/// rotations of its corners:
///
///     E = ½ Σ_t A_t ⅓ Σ_{i of t} |∇p - R_i ∇p⁰|²_t  +  ½ α A Σ_{edges ij} w_ij |R_i - R_j|²
///
/// A_t, ∇: area and gradient of the original triangles, A their sum. The first sum is the
/// spokes-and-rims energy with cotangents, Σ ½cot |e - R_i e⁰|² over the three edges of each triangle
/// at i: as gradients it is a sum of squares, so that obtuse triangles, whose cotangents are
/// negative, do no harm. w_ij: edge_cotangents (mesh/differential_operators.h), 0 where they are negative.
///
/// Rounds alternate the exact minimum over all R_i (3×3 matrices, colour by colour) and over all p
/// (one solve): E never rises. AᵀA is the cotangent Laplacian, factored once for all rounds and
/// edits. The first rotations are the harmonic field of the handles' turns, as logarithms that are
/// not reduced, so that a bar that is turned round by 360° is twisted. Surfaces of solids keep their
/// volume as far as edges and bends do; nothing holds it by itself.
///
/// Handles and fixed vertices hold exactly. A handle's scale moves its own vertices only. Cost: one
/// factor of n unknowns at construction; a round is one solve and O(triangles), without allocation.
/// Source: Sorkine and Alexa 2007; Chao et al. 2010 (spokes and rims); Levi and Gotsman 2015
/// (smoothing).
class ArapDeformer final : public IterativeDeformer {
 public:
  /// Throws InputError (check() in deform_problem.h; a triangle of no area; options that are not
  /// finite or negative), NoSolutionError.
  ArapDeformer(const TriangleMesh& mesh, std::vector<int> fixed, std::vector<Handle> handles,
               const ArapOptions& options = {});
  ~ArapDeformer() override;
  ArapDeformer(ArapDeformer&&) noexcept;
  ArapDeformer& operator=(ArapDeformer&&) noexcept;

  const Points& deform(std::span<const HandleTransform> moves) override;
  const Points& deform(std::span<const HandleTransform> moves, const Points& guess) override;
  const Points& positions() const override;
  const IterationReport& report() const override;
  /// R_i of every node after the last edit: where sheets meet they share it, so that they keep their
  /// angles.
  const std::vector<Mat3>& vertex_rotations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
