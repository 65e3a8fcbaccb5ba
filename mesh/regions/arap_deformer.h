// As-rigid-as-possible (ARAP) deformation with smoothed rotations, for large edits.
#pragma once

#include <memory>

#include "batten/mesh/regions/iterative_deformer.h"
#include "batten/mesh/triangle_mesh.h"

namespace batten {

/// Options of ArapDeformer.
struct ArapOptions {
  int max_iterations = 300;  ///< at least 1
  /// The iteration stops when no vertex moves by more, relative to the mesh size.
  double tolerance = 1e-6;
  /// α ≥ 0: penalty on differences of neighbouring rotations. It acts like the bending stiffness of
  /// a shell of thickness √(α · area). With 0 the only bending stiffness is that of the discrete
  /// ARAP energy.
  double smoothing = 0.001;
};

/// As-rigid-as-possible deformation (spokes and rims) with rotation smoothing. Each vertex has its
/// own rotation R_i, and each triangle should equal its original rotated by the rotations of its
/// corners:
///
///     E = ½ Σ_t A_t ⅓ Σ_{i of t} |∇p - R_i ∇p⁰|²_t  +  ½ α A Σ_{edges ij} w_ij |R_i - R_j|²
///
/// A_t and ∇ are the area and gradient of the original triangle t, A is the total area. The first
/// sum is the spokes-and-rims energy with cotangent weights, Σ ½cot |e - R_i e⁰|² over the three
/// edges of each triangle at i. Written with gradients it is a sum of squares, so the negative
/// cotangents of obtuse triangles do no harm. w_ij: edge_cotangents()
/// (mesh/differential_operators.h), with negative values replaced by 0.
///
/// Local/global iteration: the local step minimises exactly over all R_i (nearest rotations of 3×3
/// matrices, colour by colour), the global step over all p (one linear solve). The energy never
/// increases. AᵀA is the cotangent Laplacian; it is factored once for all iterations and edits. The
/// initial rotations are the harmonic field of the rotations of the handles, as logarithms that are
/// not reduced, so a bar rotated by 360° at one end is twisted. The surface of a solid keeps its
/// volume only indirectly, through edges and bending; there is no volume constraint.
///
/// Handles and fixed vertices are satisfied exactly. The scale of a handle affects only its own
/// vertices. Cost: one factorization with n unknowns at construction. Each iteration is one solve
/// plus O(triangles), without allocation. Sources: [SorkineAlexa2007]; [Chao2010] (spokes and
/// rims); [LeviGotsman2015] (smoothing).
class ArapDeformer final : public IterativeDeformer {
 public:
  /// Throws InputError (see check() in deform_problem.h; a triangle without area; options negative
  /// or not finite) or NoSolutionError (the factorization fails).
  ArapDeformer(const TriangleMesh& mesh, std::vector<int> fixed, std::vector<Handle> handles,
               const ArapOptions& options = {});
  ~ArapDeformer() override;
  ArapDeformer(ArapDeformer&&) noexcept;
  ArapDeformer& operator=(ArapDeformer&&) noexcept;

  const Points& deform(std::span<const HandleTransform> moves) override;
  const Points& deform(std::span<const HandleTransform> moves, const Points& guess) override;
  const Points& positions() const override;
  const IterationReport& report() const override;
  /// Rotation R_i of every node after the last edit. Patches that meet at a node have the same
  /// rotation, which preserves the angles between them.
  const std::vector<Mat3>& vertex_rotations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace batten
