// SPDX-License-Identifier: MPL-2.0
// Kirchhoff-Love shell analysis on C1 triangles: strains, stiffness, mass and stress resultants.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/element_pattern.h"
#include "batten/fem/surface.h"

namespace batten {

// Local axes and strains at one point of a Kirchhoff-Love shell.

/// Membrane strains and curvature changes of the reference surface of a shell in the local axes e1, e2
/// of a ShellPoint, each as (11, 22, 2·12). At height z above this surface, along its normal,
/// the strain is membrane + z · curvature.
struct ShellStrain {
  Vec3 membrane = Vec3::Zero(), curvature = Vec3::Zero();
};

/// Displacement U(u, v) and its derivatives at a point: columns U, U_u, U_v, U_uu, U_uv, U_vv.
using DisplacementJet = Eigen::Matrix<double, 3, kDerivatives>;

/// Geometry of a surface X(u, v) at one point. The local axes are e1 (the direction `along`,
/// projected onto the tangent plane), e2 = n × e1 and the normal n; s1, s2 are lengths along e1,
/// e2:
///
///     ε11 = e1·U,1    ε22 = e2·U,2    2ε12 = e1·U,2 + e2·U,1
///     κ_αβ = -n·(U,αβ - Γ^γ_αβ U,γ)   (α, β over u, v), transformed to e1, e2.
///
/// This is the linear Kirchhoff-Love theory: normals stay straight and perpendicular to the
/// surface. Rigid-body motions cause no strain. Reference: docs/theory/shells.md.
class ShellPoint {
 public:
  /// `jet`: position and derivatives of the surface; `along`: direction whose projection onto the
  /// tangent plane is e1; zero: e1 is along x_u. Throws InputError if x_u × x_v = 0.
  ShellPoint(const SurfaceJet& jet, const Vec3& along);

  const Vec3& e1() const { return e1_; }
  const Vec3& e2() const { return e2_; }
  const Vec3& normal() const { return n_; }
  /// Jacobian |x_u × x_v|: surface area per area of (u, v).
  double jacobian() const { return jacobian_; }

  /// Derivatives of functions along e1 (`axis` = 0) or e2 (`axis` = 1), computed from their
  /// derivatives f_u and f_v; one column per function.
  template <class U, class V>
  auto along_axes(int axis, const U& f_u, const V& f_v) const {
    return gradient_(axis, 0) * f_u + gradient_(axis, 1) * f_v;
  }
  /// Covariant second derivatives of the 12 shape functions along the local axes e1, e2, with rows
  /// (11, 22, 2·12). Multiplied by -normal(), they give the curvature changes.
  Eigen::Matrix<double, 3, 12> bending_matrix(const Tabulation& functions) const;

  /// Strains at this point caused by a displacement. `U`: the displacement and its derivatives.
  ShellStrain strain(const DisplacementJet& U) const;

 private:
  Vec3 e1_, e2_, n_;
  double jacobian_;
  Eigen::Matrix<double, 2, 2> gradient_;     // (f,1; f,2) = gradient · (f,u; f,v)
  Eigen::Matrix<double, 3, 2> christoffel_;  // Γ^u, Γ^v of uu, uv, vv
  Mat3 voigt_;                               // (11, 22, 2·12) from (uu, uv, vv)
};

/// Element load vector (12×3) of stress resultants per area: its work with a displacement is that of
/// `forces` (N11, N22, N12) and `moments` (M11, M22, M12) with its strains. `N`: shape functions.
Eigen::Matrix<double, 12, 3> nodal_forces(const Tabulation& N, const ShellPoint& at,
                                          const Vec3& forces, const Vec3& moments);

/// Change of temperature at a point: in the middle of the shell, and from bottom to top.
struct TemperatureAt {
  double middle = 0, difference = 0;
};

// Fast evaluation of one shell triangle at many points.

/// Geometry, shape functions and displacements of one triangle at points whose reference functions
/// are tabulated (TabulatedRule). This takes a fraction of the time of evaluating each point from
/// scratch.
class ShellTriangle {
 public:
  using Dofs = Eigen::Matrix<double, 12, 3>;

  ShellTriangle(const Surface& surface, int t, const Vec3& along)
      : triangle_(surface.kind(), surface.mesh().shape(t)),
        map_(triangle_.shape()),
        shape_(triangle_.pull_back(surface.triangle_dofs(t))),
        along_(along) {}

  /// Area of the triangle in (u, v).
  double parametric_area() const { return triangle_.shape().area; }
  /// Converts the element dofs q of a displacement to reference dofs, the argument of jet().
  Dofs reference(const Dofs& q) const { return triangle_.pull_back(q); }

  /// Displacement and its derivatives at a point, from the reference dofs and the reference
  /// functions tabulated at the point.
  DisplacementJet jet(const Dofs& reference, const ReferenceTabulation& functions) const {
    const Eigen::Matrix<double, 3, 6> local = reference.transpose().lazyProduct(functions);
    DisplacementJet jet;
    jet.col(kW) = local.col(0);
    jet.middleCols<2>(kU) = local.middleCols<2>(1).lazyProduct(map_.first.transpose());
    jet.middleCols<3>(kUU) = local.middleCols<3>(3).lazyProduct(map_.second.transpose());
    return jet;
  }
  /// Geometry of the surface at a point with tabulated reference functions.
  ShellPoint point(const ReferenceTabulation& functions) const {
    const DisplacementJet x = jet(shape_, functions);
    return {{x.col(kW), x.col(kU), x.col(kV), x.col(kUU), x.col(kUV), x.col(kVV)}, along_};
  }
  /// Matrix that maps element dofs to reference dofs; compute it once per triangle. functions():
  /// shape functions of the element dofs, from this matrix P and the tabulated reference functions
  /// f.
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

/// Kirchhoff-Love shell on a C1 surface. Displacements use the shape functions of the surface
/// itself, U = Σ N_m q_m, so the design mesh is also the analysis mesh.
///
///     K = ∬ (t εᵀ A ε + 2 t² εᵀ B κ + t³ κᵀ D κ) J du dv         K q = F,  F = ∬ N f J du dv
///
/// t: thickness; A, B, D: SectionIntegrals, for one material A = Q, B = 0, D = Q/12; ε, κ: membrane
/// strain in the middle of the shell and curvature change; J: area per area of (u, v). K couples x, y and z: it is 3n×3n over the stacked dofs [x; y; z], with n
/// dofs per coordinate. Loads of SurfaceAssembler can be used: point_load(), area_load() (force per
/// area), pressure_load() (pressure along the normal). Supports are a ConstraintSet of
/// Kind::Coupled for ConstrainedSolver. With a trim, the part of the mesh inside it counts fully,
/// and the rest with the factor `outside`, as in SurfaceAssembler.
///
/// Quadrature: HCT with 6 points on each sub-triangle, Z12 with the six-Duffy rule m = 4, because
/// ordinary rules are inconsistent for Z12. Coarse meshes of curved shells show membrane locking:
/// use at least 8 elements per quarter circle, better 16. Reference: docs/theory/shells.md.
class ShellAssembler {
 public:
  /// `sections`: one for all triangles, or one per triangle. `outside`: factor of the stiffness
  /// outside of the trim. Throws InputError for another number of sections, an invalid section
  /// (require_section()), or a surface without a normal at some point.
  ShellAssembler(Surface surface, std::vector<ShellSection> sections, double outside = 1e-6);

  /// Replaces the surface by one on the same mesh. Throws InputError if the mesh differs.
  void update_shape(Surface surface);
  /// Replaces the sections: one for all triangles, or one per triangle. Throws as the constructor.
  void update_sections(std::vector<ShellSection> sections);

  /// Stiffness matrix of the shell, 3n×3n (lower triangle). Cost: O(triangles), on all threads;
  /// results are bit-identical for any number of them.
  SparseMatrix stiffness() const;

  /// Mass matrix ∬ ρ t N Nᵀ dA of one coordinate (lower triangle, n×n), valid for each of x, y and
  /// z, with the density ρ, thickness t and shape functions N. On a trimmed surface, only the part
  /// inside the trim counts. Rotary inertia is neglected, as usual for thin shells, and so is the
  /// distance of the mass from the reference surface.
  SparseMatrix mass() const;
  /// Geometric stiffness G = ∬ (N11 N,1 N,1ᵀ + N22 N,2 N,2ᵀ + N12 (N,1 N,2ᵀ + N,2 N,1ᵀ)) dA of one
  /// coordinate, with the membrane forces N11, N22, N12 of a displacement q (n×3) and the
  /// derivatives N,1, N,2 of the shape functions along the local axes. ½ uᵀ G u is the energy that
  /// these forces add when the shell is displaced further by u (negative if they release energy).
  /// `temperature`: that of q's load case. Throws InputError if q has the wrong number of dofs.
  SparseMatrix geometric_stiffness(const Points& q, const ShellTemperature& temperature = {}) const;
  /// Load vector (n×3) of a change of temperature: F = ∬ (εᵀ N_T + κᵀ M_T) dA, with the resultants N_T
  /// and M_T of the stresses that would prevent the expansion. Throws InputError unless there is one
  /// temperature per vertex of the mesh.
  Points thermal_load(const ShellTemperature& temperature) const;

  /// Strains in local axes that a displacement q (n×3) causes at one point. Throws InputError if q
  /// has the wrong number of dofs.
  ShellStrain strain(const Points& q, const Location& where) const;
  /// Stress (σ11, σ22, σ12) in local axes caused by a displacement q (n×3), at height z above the
  /// middle of the shell; z from -t/2 to t/2 for the thickness t.
  Vec3 stress(const Points& q, const Location& where, double z) const;
  /// Stress resultants: membrane forces (N11, N22, N12) and moments (M11, M22, M12) about the
  /// reference surface, per length, in local axes.
  struct Resultants {
    Vec3 forces, moments;
  };
  Resultants resultants(const Points& q, const Location& where,
                        const ShellTemperature& temperature = {}) const;
  /// Stress resultants for a given strain at the barycentric coordinates L of a triangle.
  Resultants resultants(int triangle, const Vec3& L, const ShellStrain& strain,
                        const TemperatureAt& temperature = {}) const;
  /// Temperature at the barycentric coordinates L of a triangle; 0 without a temperature.
  TemperatureAt temperature_at(const ShellTemperature& temperature, int triangle,
                               const Vec3& L) const;
  /// Geometry of the shell at a location, with the local axes to which strains, stresses and
  /// resultants refer.
  ShellPoint point(const Location& where) const;

  /// Calls `visit` at each quadrature point of the stiffness of a triangle, with the surface area
  /// that the point represents. On a trimmed surface, only points inside the trim are visited.
  ///
  /// The strain at the point, caused by a displacement with dofs q on the triangle, is
  /// point.strain(triangle.jet(triangle.reference(q), functions)). This is ten times as fast as
  /// strain().
  using PointVisitor =
      std::function<void(const ShellTriangle& triangle, const ReferenceTabulation& functions,
                         const ShellPoint& point, const Vec3& L, double area)>;
  void for_each_quadrature_point(int triangle, const PointVisitor& visit) const;
  /// Calls `visit` at each point of the quadrature rule `whole` on a triangle. On triangles that
  /// the trim cuts, the points are those of Trim::rule() with the given degree.
  void for_each_quadrature_point(int triangle, const TabulatedRule& whole, int degree,
                                 const PointVisitor& visit) const;
  /// Dofs on one triangle (12×3) of a displacement q (n×3).
  Eigen::Matrix<double, 12, 3> dofs_on(const Points& q, int triangle) const;

  const Surface& surface() const { return surface_; }
  /// Shell section (material and thickness) of a triangle.
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
  // Integrates a matrix of one coordinate over the part inside the trim; add(triangle, rule, K)
  // adds the contribution of a triangle.
  SparseMatrix integrate_inside(const std::function<void(int triangle, const TabulatedRule& rule,
                                                         ScalarMatrix& K)>& add) const;

  Surface surface_;
  std::vector<ShellSection> sections_;
  double outside_;
  std::shared_ptr<const ElementPattern> pattern_;  // shared by copies
};

}  // namespace batten
