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

namespace batten {

/// A point of a surface mesh: triangle and barycentric coordinates in it.
struct Location {
  int triangle = 0;
  Vec3 L = Vec3::Constant(1.0 / 3);
};

class SurfaceAssembler {
 public:
  using MaterialField = std::function<SurfaceStiffness(const Vec2& uv)>;
  using LoadField = std::function<Vec3(const Location& where, const Vec2& uv)>;

  /// Keeps a reference to the mesh. O(triangles).
  SurfaceAssembler(const ParametricMesh& mesh, TriangleElement kind);

  /// A matrix of the right pattern, for the functions below that write into one.
  SparseMatrix pattern() const { return pattern_.zero(); }

  /// Constant material: exact, no quadrature.
  void stiffness(const SurfaceStiffness& material, SparseMatrix& K) const;
  /// One material for each triangle: exact, no quadrature. Throws InputError on a wrong count.
  void stiffness(const std::vector<SurfaceStiffness>& materials, SparseMatrix& K) const;
  /// Material that varies inside triangles, by C1Triangle::varying_rule. The field is called from
  /// several threads.
  void stiffness(const MaterialField& material, SparseMatrix& K) const;
  SparseMatrix stiffness(const SurfaceStiffness& material) const;

  /// ∬ N Nᵀ.
  SparseMatrix mass() const;
  /// ∬ N f for constant f: exact.
  Points load(const Vec3& f) const;
  /// ∬ N f for f that varies: HCT by the symmetric rule of `degree` (0 to 8; 6 is exact for cubic
  /// f) on each sub-triangle, Z12 by six-Duffy with m = 5. f is called from several threads.
  Points load(const LoadField& f, int degree = 6) const;
  /// ∬ N (x_u × x_v) du dv for the surface with dofs q: the load of a unit pressure that follows
  /// the surface's normal. HCT: exact.
  Points pressure_load(const Points& q) const;
  /// A force at one point of the surface.
  Points point_load(const Location& where, const Vec3& force) const;

  const ParametricMesh& mesh() const { return mesh_; }
  const DofMap& dofs() const { return dofs_; }
  TriangleElement kind() const { return kind_; }

 private:
  using ElementLoad = Eigen::Matrix<double, 12, 3>;
  // Sum of the elements' loads, each in reference dofs.
  Points gather(const std::function<void(int triangle, ElementLoad& reference)>& element) const;

  const ParametricMesh& mesh_;
  TriangleElement kind_;
  DofMap dofs_;
  std::vector<TriangleShape> shapes_;
  ElementPattern pattern_;
};

}  // namespace batten
