// Stiffness of Kirchhoff-Love shells on C1 triangles.
#pragma once

#include <functional>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/fem/element_pattern.h"
#include "batten/fem/surface.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/reference_triangle.h"

namespace batten {

// One point of a Kirchhoff-Love shell: its local axes, and strains from displacements there.

/// Strains of the middle surface and changes of its curvature in local axes, each (11, 22, 2·12).
/// At height z above the middle surface, along its normal, the strain is membrane + z · curvature.
struct ShellStrain {
  Vec3 membrane = Vec3::Zero(), curvature = Vec3::Zero();
};

/// The displacement U(u, v) and its derivatives at a point: columns w, u, v, uu, uv, vv.
using DisplacementJet = Eigen::Matrix<double, 3, kDerivatives>;

/// Geometry of a surface X(u, v) at one point. With e1 the direction `along` in the tangent plane,
/// n the normal, e2 = n × e1, and s1, s2 lengths along e1, e2:
///
///     ε11 = e1·U,1    ε22 = e2·U,2    2ε12 = e1·U,2 + e2·U,1
///     κ_αβ = -n·(U,αβ - Γ^γ_αβ U,γ)   (α, β over u, v), carried to e1, e2.
///
/// Linear theory of Kirchhoff and Love: normals stay straight and at right angles to the surface.
/// Rigid motions have no strain. Source: docs/theory/shells.md.
class ShellPoint {
 public:
  /// Throws InputError where x_u × x_v = 0.
  ShellPoint(const SurfaceJet& jet, const Vec3& along);

  const Vec3& e1() const { return e1_; }
  const Vec3& e2() const { return e2_; }
  const Vec3& normal() const { return n_; }
  /// |x_u × x_v|: area of the surface for one of (u, v).
  double jacobian() const { return jacobian_; }

  /// Derivatives of functions along e1 and e2, from those along u and v; one column a function.
  template <class U, class V>
  auto along_axes(int axis, const U& f_u, const V& f_v) const {
    return gradient_(axis, 0) * f_u + gradient_(axis, 1) * f_v;
  }
  /// Rows (11, 22, 2·12) of -κ/n: (f,αβ - Γ^γ_αβ f,γ) of the 12 functions of a triangle, in e1, e2.
  Eigen::Matrix<double, 3, 12> bending_matrix(const Tabulation& functions) const;

  ShellStrain strain(const DisplacementJet& U) const;

 private:
  Vec3 e1_, e2_, n_;
  double jacobian_;
  Eigen::Matrix<double, 2, 2> gradient_;     // (f,1; f,2) = gradient · (f,u; f,v)
  Eigen::Matrix<double, 3, 2> christoffel_;  // Γ^u, Γ^v of uu, uv, vv
  Mat3 voigt_;                               // (11, 22, 2·12) from (uu, uv, vv)
};


// One triangle of a shell at many points.

/// Geometry, functions and displacements at places of which the reference functions are known
/// (TabulatedRule): a fraction of the time of evaluating each anew.
class ShellTriangle {
 public:
  using Dofs = Eigen::Matrix<double, 12, 3>;

  ShellTriangle(const Surface& surface, int t, const Vec3& along)
      : triangle_(surface.kind(), surface.mesh().shape(t)),
        map_(triangle_.shape()),
        shape_(triangle_.pull_back(surface.triangle_dofs(t))),
        along_(along) {}

  double parametric_area() const { return triangle_.shape().area; }
  /// The dofs q of a displacement on this triangle, as jet() wants them.
  Dofs reference(const Dofs& q) const { return triangle_.pull_back(q); }

  DisplacementJet jet(const Dofs& reference, const ReferenceTabulation& functions) const {
    const Eigen::Matrix<double, 3, 6> local = reference.transpose().lazyProduct(functions);
    DisplacementJet jet;
    jet.col(kW) = local.col(0);
    jet.middleCols<2>(kU) = local.middleCols<2>(1).lazyProduct(map_.first.transpose());
    jet.middleCols<3>(kUU) = local.middleCols<3>(3).lazyProduct(map_.second.transpose());
    return jet;
  }
  ShellPoint point(const ReferenceTabulation& functions) const {
    const DisplacementJet x = jet(shape_, functions);
    return {{x.col(kW), x.col(kU), x.col(kV), x.col(kUU), x.col(kUV), x.col(kVV)}, along_};
  }
  /// The functions of the dofs themselves. P: pull_back_matrix(), once a triangle.
  Mat12 pull_back_matrix() const { return triangle_.pull_back_matrix(); }
  Tabulation functions(const Mat12& P, const ReferenceTabulation& f) const {
    Tabulation local;
    local.col(kW) = f.col(0);
    local.middleCols<2>(kU) = f.middleCols<2>(1).lazyProduct(map_.first.transpose());
    local.middleCols<3>(kUU) = f.middleCols<3>(3).lazyProduct(map_.second.transpose());
    return P.transpose().lazyProduct(local);
  }

 private:
  C1Triangle triangle_;
  DerivativeMap map_;
  Dofs shape_;
  Vec3 along_;
};


/// The shell that a surface is: its displacements are in the surface's own C1 functions,
/// U = Σ N_m q_m, so that the mesh of the design carries the analysis.
///
///     K = ∬ (t εᵀ Q ε + t³/12 κᵀ Q κ) J du dv         K q = F,  F = ∬ N f J du dv
///
/// K mixes x, y and z: it is 3n×3n over the stacked dofs [x; y; z] of n dofs a coordinate. Loads of
/// SurfaceAssembler are loads here too: point_load, area_load (a force per area), pressure_load (a
/// pressure along the normal). Supports are a ConstraintSet of Kind::Coupled for ConstrainedSolver.
/// With a trim, the inside counts, and `outside` times the rest, as in SurfaceAssembler.
///
/// Rules: HCT 6 points on each sub-triangle, Z12 six-Duffy with m = 4; ordinary rules are
/// inconsistent on Z12. On coarse meshes of curved shells membrane stiffness locks bending:
/// 8 elements a quarter are the least, 16 are good. Source: docs/theory/shells.md.
class ShellAssembler {
 public:
  /// `sections`: one, or one for each triangle. Throws InputError: another count, a section that is
  /// none (require_section), a surface without a normal somewhere.
  ShellAssembler(Surface surface, std::vector<ShellSection> sections, double outside = 1e-6);

  /// Another shape of the same mesh. Throws InputError for another mesh.
  void update_shape(Surface surface);

  /// The lower triangle of K. O(triangles), on all threads; the same bits on one.
  SparseMatrix stiffness() const;

  /// M = ∬ ρ t N Nᵀ J du dv, the lower triangle of one coordinate, n×n: the same for x, y and z. Of a
  /// trimmed surface the inside counts only. Rotary inertia is left out, as thin shells have it.
  SparseMatrix mass() const;
  /// G = ∬ (N11 N,1 N,1ᵀ + N22 N,2 N,2ᵀ + N12 (N,1 N,2ᵀ + N,2 N,1ᵀ)) J du dv with the membrane forces
  /// of a displacement q, likewise: the energy ½ uᵀ G u that these forces give up or take where the
  /// shell moves on by u. Throws InputError for another number of dofs.
  SparseMatrix geometric_stiffness(const Points& q) const;

  /// What a displacement q (n×3) does at one place. Throws InputError for another number of dofs.
  ShellStrain strain(const Points& q, const Location& where) const;
  /// Stress (σ11, σ22, σ12) at the height z above the middle surface, -t/2 … t/2.
  Vec3 stress(const Points& q, const Location& where, double z) const;
  /// Forces (N11, N22, N12) and moments (M11, M22, M12) per length.
  struct Resultants {
    Vec3 forces, moments;
  };
  Resultants resultants(const Points& q, const Location& where) const;
  /// Those of a strain at a place.
  Resultants resultants(int triangle, const Vec3& L, const ShellStrain& strain) const;
  /// The point with its local axes, in which strains, stresses and resultants are.
  ShellPoint point(const Location& where) const;

  /// Calls visit at the points of the stiffness's rule that are inside of a triangle, with the area
  /// that each stands for: point.strain(triangle.jet(triangle.reference(q), functions)) is what q does
  /// there, in a tenth of the time of strain().
  using PointVisitor =
      std::function<void(const ShellTriangle& triangle, const ReferenceTabulation& functions,
                         const ShellPoint& point, const Vec3& L, double area)>;
  void for_each_quadrature_point(int triangle, const PointVisitor& visit) const;
  /// The same at points of another rule, and in cut triangles of their rule of a degree.
  void for_each_quadrature_point(int triangle, const TabulatedRule& whole, int degree,
                                 const PointVisitor& visit) const;
  /// Dofs of a displacement on one triangle.
  Eigen::Matrix<double, 12, 3> dofs_on(const Points& q, int triangle) const;

  const Surface& surface() const { return surface_; }
  const ShellSection& section(int triangle) const {
    return sections_[sections_.size() == 1 ? 0 : static_cast<size_t>(triangle)];
  }

 private:
  using ElementMatrix = Eigen::Matrix<double, 36, 36, Eigen::RowMajor>;
  using ScalarMatrix = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;
  // Calls visit(N, point, L, weight) at the points of a rule; the weight is an area of the surface.
  template <class Visit>
  void for_each_point(int triangle, const TabulatedRule& rule, const Visit& visit) const;
  int cut_degree() const;
  // Adds the integral over a rule, times `factor`, to the lower triangle of K.
  void add(int triangle, const TabulatedRule& rule, double factor, ElementMatrix& K) const;
  // A matrix of one coordinate, integrated over the inside; add(triangle, rule, K) of a part.
  SparseMatrix integrate_inside(const std::function<void(int triangle, const TabulatedRule& rule,
                                                         ScalarMatrix& K)>& add) const;

  Surface surface_;
  std::vector<ShellSection> sections_;
  double outside_;
  ElementPattern pattern_;
};

}  // namespace batten
