// One point of a Kirchhoff-Love shell: its local axes, and strains from displacements there.
#pragma once

#include "batten/fem/surface.h"

namespace batten {

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

}  // namespace batten
