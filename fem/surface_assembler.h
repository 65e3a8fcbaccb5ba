// Stiffness, mass and loads of whole surfaces.
//
// Energy of one coordinate: E = qᵀK q - 2 Fᵀq, so the minimum satisfies K q = F. x, y and z share
// K; loads and dofs have one column for each. Matrices are symmetric, kept by their LOWER triangle.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "batten/fem/element_pattern.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/trim.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/fem/triangle_locator.h"

namespace batten {

class Surface;

class SurfaceAssembler {
 public:
  using MaterialField = std::function<SurfaceStiffness(const Vec2& uv)>;
  using LoadField = std::function<Vec3(const Location& where, const Vec2& uv)>;

  /// Keeps a reference to the mesh. With a trim, all integrals run over the inside only; stiffness
  /// also over `outside` times the rest of the mesh, which keeps the matrix well conditioned
  /// however small a cut is and changes results less than the mesh does (docs/theory/domains.md).
  /// O(triangles).
  SurfaceAssembler(const ParametricMesh& mesh, TriangleElement kind,
                   std::shared_ptr<const Trim> trim = nullptr, double outside = 1e-6);

  /// A matrix of the right pattern, for the functions below that write into one.
  SparseMatrix pattern() const { return pattern_.zero(); }

  /// Stiffness of a constant material: exact, no quadrature.
  void stiffness(const SurfaceStiffness& material, SparseMatrix& K) const;
  /// Stiffness of one material for each triangle: exact, no quadrature. Throws InputError on a
  /// wrong count.
  void stiffness(const std::vector<SurfaceStiffness>& materials, SparseMatrix& K) const;
  /// Stiffness of a material that varies inside triangles, by C1Triangle::default_quadrature. The field
  /// is called from several threads.
  void stiffness(const MaterialField& material, SparseMatrix& K) const;
  SparseMatrix stiffness(const SurfaceStiffness& material) const;

  /// Mass ∬ w N Nᵀ, w constant in each triangle; none: 1 everywhere. Throws InputError on a wrong
  /// count.
  SparseMatrix mass(const VecX& triangle_weights = VecX()) const;
  /// Load ∬ N f of a constant f: exact.
  Points load(const Vec3& f) const;
  /// Load ∬ N f of an f that varies: HCT by the symmetric rule of `degree` (0 to 8; 6 is exact for
  /// cubic f) on each sub-triangle, Z12 by six-Duffy with m = 5. f is called from several threads.
  Points load(const LoadField& f, int degree = 6) const;
  /// Load ∬ w N, w constant in each triangle, one number a dof: exact on whole triangles. Throws
  /// InputError on a wrong count.
  VecX load(const VecX& triangle_weights) const;
  /// ∬ N |x_u × x_v| du dv for a surface on this mesh: a unit load per area of the surface, one
  /// number a dof. Not a polynomial: by the rules of pressure_load. Throws InputError for a surface
  /// with another number of dofs.
  VecX area_load(const Surface& surface) const;
  /// ∬ N (x_u × x_v) du dv for the surface with dofs q: the load of a unit pressure that follows
  /// the surface's normal. HCT: exact. By quadrature; PressureOperator is ten times as fast.
  Points pressure_load(const Points& q) const;
  /// Load of a force at one point of the surface.
  Points point_load(const Location& where, const Vec3& force) const;

  const ParametricMesh& mesh() const { return mesh_; }
  const DofMap& dofs() const { return dofs_; }
  TriangleElement kind() const { return kind_; }

 private:
  using ElementLoad = Eigen::Matrix<double, 12, 3>;
  ElementLoad reference_dofs(int triangle, const Points& q) const;
  void check_weights(const VecX& triangle_weights) const;
  // ∬ N over the part of a triangle that is inside.
  Vec12 unit_load(int triangle) const;
  // Sum of the elements' loads, each in reference dofs.
  Points gather(const std::function<void(int triangle, ElementLoad& reference)>& element) const;

  using MaterialAt = std::function<SurfaceStiffness(const Vec3& L)>;
  // The share inside of a whole element matrix: K becomes `outside` K + (1 - outside) K inside.
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


// A load along a line of the surface.

/// ∫ N(c(t)) |X'(t)| dt, one number a dof: the load of a unit force per length of the line. Times a
/// direction it is a load of the surface; position dofs add up to the line's length.
/// `pcurve`: c(t) in (u, v), z = 0; `curve`: X(t) in space; both over the same parameters (EdgeAlignedLine:
/// edge_aligned_pcurve and `fitted`; EmbeddedLine: `pcurve` and `fitted`). The line is cut where it passes
/// from one cubic of an element to the next; six Gauss points on pieces no longer than half an
/// element, right to 1e-8 and better. Throws InputError when the two curves have different
/// intervals. O(length / element size), some microseconds each.
VecX line_load(const ParametricMesh& mesh, TriangleElement kind, const TriangleLocator& locator,
               const HermiteCurve& pcurve, const HermiteCurve& curve);

}  // namespace batten
