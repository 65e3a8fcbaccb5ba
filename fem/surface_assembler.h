// SPDX-License-Identifier: MPL-2.0
// Assembles stiffness, mass and loads of a surface.
//
// The energy of one coordinate is E = ½ qᵀK q - Fᵀq, so the minimum satisfies K q = F. x, y and z
// share K; loads and dofs have one column per coordinate. Matrices are symmetric and stored as
// their LOWER triangle.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/element_pattern.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/triangle_locator.h"
#include "batten/fem/trim.h"

namespace batten {

class Surface;

/// Assembles matrices and load vectors of C1 triangle elements over a parametric mesh.
class SurfaceAssembler {
 public:
  using MaterialField = std::function<SurfaceStiffness(const Vec2& uv)>;
  using LoadField = std::function<Vec3(const Location& where, const Vec2& uv)>;

  /// Keeps a reference to the mesh. With a trim, all integrals extend over the inside of the trim.
  /// Only the stiffness also includes the rest of the mesh, multiplied by `outside`. This factor
  /// keeps the matrix well conditioned however small the cuts are, and changes results by less than
  /// the discretisation error (docs/theory/domains.md). Cost: O(triangles).
  SurfaceAssembler(const ParametricMesh& mesh, TriangleElement kind,
                   std::shared_ptr<const Trim> trim = nullptr, double outside = 1e-6);

  /// Zero matrix with the sparsity pattern of the assembled matrices, as argument `K` of
  /// stiffness().
  SparseMatrix pattern() const { return pattern_.zero(); }

  /// Computes the stiffness matrix for a constant material, exactly and without quadrature. `K`: a
  /// matrix with the sparsity of pattern(), which is overwritten.
  void stiffness(const SurfaceStiffness& material, SparseMatrix& K) const;
  /// Computes the stiffness matrix for one material per triangle, exactly and without quadrature.
  /// `K`: a matrix with the sparsity of pattern(), which is overwritten. Throws InputError for a
  /// wrong number of materials.
  void stiffness(const std::vector<SurfaceStiffness>& materials, SparseMatrix& K) const;
  /// Computes the stiffness matrix for a material that varies inside triangles, by
  /// C1Triangle::default_quadrature(). `material` is called from several threads. `K`: a matrix
  /// with the sparsity of pattern(), which is overwritten.
  void stiffness(const MaterialField& material, SparseMatrix& K) const;
  SparseMatrix stiffness(const SurfaceStiffness& material) const;

  /// Mass matrix ∬ w N Nᵀ du dv with the shape functions N. `triangle_weights`: one weight w per
  /// triangle; empty: w = 1. Throws InputError for a wrong number of weights.
  SparseMatrix mass(const VecX& triangle_weights = VecX()) const;
  /// Load vector ∬ N f du dv of a constant force f per area of (u, v), with the shape functions N;
  /// exact.
  Points load(const Vec3& f) const;
  /// Load vector ∬ N f du dv of a variable force f per area of (u, v), with the shape functions N.
  /// HCT elements: symmetric quadrature of `degree` (0 to 8; 6 is exact for cubic f) on each
  /// sub-triangle. Z12 elements: six_duffy_rule(5). f is called from several threads.
  Points load(const LoadField& f, int degree = 6) const;
  /// Load vector ∬ w N du dv of the force w per area of (u, v), with the shape functions N, one
  /// number per dof; exact on triangles that no trim cuts. `triangle_weights`: w for each triangle.
  /// Throws InputError for a wrong number of weights.
  VecX load(const VecX& triangle_weights) const;
  /// Load vector ∬ N |x_u × x_v| du dv of a unit force per area of a surface x on this mesh, with
  /// the shape functions N, one number per dof. The integrand is not polynomial; the quadrature
  /// rules are those of pressure_load(). Throws InputError if the surface has a different number of
  /// dofs.
  VecX area_load(const Surface& surface) const;
  /// Load vector ∬ N (x_u × x_v) du dv of a unit pressure along the normal of the surface x with
  /// dofs q (n×3) and shape functions N. Computed by quadrature, exact for HCT; PressureOperator is
  /// ten times as fast.
  Points pressure_load(const Points& q) const;
  /// Load vector of a point force on the surface.
  Points point_load(const Location& where, const Vec3& force) const;

  const ParametricMesh& mesh() const { return mesh_; }
  const DofMap& dofs() const { return dofs_; }
  TriangleElement kind() const { return kind_; }

 private:
  using ElementLoad = Eigen::Matrix<double, 12, 3>;
  ElementLoad reference_dofs(int triangle, const Points& q) const;
  void check_weights(const VecX& triangle_weights) const;
  // ∬ N du dv over the part of a triangle inside the trim, with the element's shape functions N.
  Vec12 unit_load(int triangle) const;
  // Sums element loads, given in reference dofs, to a load vector of the mesh.
  Points gather(const std::function<void(int triangle, ElementLoad& reference)>& element) const;

  using MaterialAt = std::function<SurfaceStiffness(const Vec3& L)>;
  // Restricts the stiffness matrix of a whole element to its part inside the trim: K becomes
  // `outside` K + (1 - outside) K_inside.
  void cut(int triangle, const MaterialAt& material, double* K) const;
  bool is_cut(int t) const { return trim_ && trim_->side(t) == Trim::Side::Cut; }
  bool is_outside(int t) const { return trim_ && trim_->side(t) == Trim::Side::Outside; }

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  std::shared_ptr<const Trim> trim_;
  double outside_;
  DofMap dofs_;
  std::vector<TriangleShape> shapes_;
  ElementPattern pattern_;
};

// Line load on a surface.

/// Load vector ∫ N(c(t)) |X'(t)| dt of a unit force per length along a curve on a surface with the
/// shape functions N, one number per dof. Multiply it by a force per length to get the load in x, y
/// and z. The entries of the position dofs sum to the length of the curve.
///
/// `pcurve`: the curve c(t) in (u, v), with z = 0; `curve`: the curve X(t) in space, over the same
/// interval of t. For an EdgeAlignedLine these are edge_aligned_pcurve() and `fitted`, for an
/// EmbeddedLine `pcurve` and `fitted`. The curve is split where it crosses from one polynomial
/// piece of the elements to the next. Six Gauss points are used per piece of at most half an
/// element; the error is 1e-8 or less. Throws InputError if the parameter intervals differ. Cost:
/// some microseconds per piece.
VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& pcurve, const HermiteCurve& curve);

}  // namespace batten
