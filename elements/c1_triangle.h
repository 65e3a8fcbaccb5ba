// The two C1 triangles with 12 dofs a coordinate: HCT and Z12.
//
//                 V3  w, w_u, w_v                     dof order of one coordinate:
//                 o                                   [w1 w1_u w1_v  w2 w2_u w2_v  w3 w3_u w3_v
//                / \                                   wn1 wn2 wn3]
//        wn2 ──>/   \<── wn1
//              /     \                                Edge i is opposite vertex i. Along every edge
//             /   ^   \                               w is cubic and its normal derivative is
//            o────│────o                              quadratic, so both triangles have the same
//     V1         wn3        V2                        value and gradient on all three edges and may
//  w, w_u, w_v         w, w_u, w_v                    be mixed in one mesh.
//
// Edge normal: one dof w_n = w_u n_u + w_v n_v at the edge's midpoint, shared by both triangles.
// t is the unit vector from the end with the LOWER global index to the higher one, n = (-t_v, t_u)
// (t turned by +90°). edge_sign[i] = +1 when the edge runs along its triangle's counter-clockwise
// direction (global(V_j) < global(V_k), (i, j, k) cyclic), so that n points into it, else -1.
//
//   HCT  three cubics on (V_j, V_k, centroid): polynomial, integrates exactly, exact CAD patches.
//   Z12  the rational triangle of Celniker and Gossard 1991: smooth inside, but its second
//        derivatives have no single value at a vertex (they depend on the direction of approach).
// Both contain all cubics and are C1, no more.
//
// Inside, both are built the same way. For dofs that any affine map carries along,
//   [w_i, ∂w_i along V_j-V_i, ∂w_i along V_k-V_i] at the vertices and m_i = ∂w along V_i - M_i at
//   the midpoint M_i of edge i,
// the shape functions are fixed functions N̂(L) of the barycentric coordinates. The dofs above
// follow by one sparse 12×12 matrix P of the triangle's shape: q̂ = P q, so N = Pᵀ N̂.
#pragma once

#include <array>

#include "batten/core/eigen.h"
#include "batten/elements/quadrature.h"

namespace batten {

enum class TriangleElement { HCT, Z12 };

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// Columns of a tabulation: value and derivatives up to order two.
enum Derivative { kW = 0, kU, kV, kUU, kUV, kVV, kDerivatives };

/// The twelve functions at a point: row a is that of dof a, columns w, w_u, w_v, w_uu, w_uv, w_vv.
using Tabulation = Eigen::Matrix<double, 12, kDerivatives>;

/// The shape of one parametric triangle: everything an element needs to know of it.
struct TriangleShape {
  std::array<Vec2, 3> vertex;
  std::array<double, 3> edge_sign{1, 1, 1};
  std::array<double, 3> b{}, c{};  ///< b_i = v_j - v_k, c_i = u_k - u_j
  double area = 0;

  /// Counter-clockwise vertices. Throws InputError when the area is not > 0 or a number is not
  /// finite.
  TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                const std::array<double, 3>& signs = {1, 1, 1});

  Vec2 point(const Vec3& L) const { return L[0] * vertex[0] + L[1] * vertex[1] + L[2] * vertex[2]; }
  /// Barycentric coordinates of a point, which may lie outside.
  Vec3 barycentric(const Vec2& p) const;
};

/// Material of the energy
///
///     E = ∬ (a11 w_u² + 2 a12 w_u w_v + a22 w_v² + b11 w_uu² + 2 b12 w_uv² + b22 w_vv²
///            + 2 m1 w_uu w_uv + 2 m2 w_uu w_vv + 2 m3 w_uv w_vv) du dv,
///
/// beta = (b11, b12, b22), beta_mixed = (m1, m2, m3), zero but for resistance in a direction of its
/// own. Valid: alpha and [[b11 m1 m2], [m1 2 b12 m3], [m2 m3 b22]] positive semi-definite.
/// b11 = b12 = b22 without mixed terms is the rotation-invariant bending energy.
struct SurfaceStiffness {
  Mat2 alpha = Mat2::Zero();
  Vec3 beta = Vec3::Ones();
  Vec3 beta_mixed = Vec3::Zero();

  static SurfaceStiffness isotropic(double alpha, double beta) {
    return {alpha * Mat2::Identity(), Vec3::Constant(beta)};
  }
  /// alpha w_t² + beta w_tt²: resistance in one direction t of (u, v) only. Throws InputError when
  /// t is not of length 1.
  static SurfaceStiffness directional(const Vec2& t, double alpha, double beta);

  SurfaceStiffness& operator+=(const SurfaceStiffness& other);
  SurfaceStiffness& operator*=(double factor);
  friend SurfaceStiffness operator+(SurfaceStiffness a, const SurfaceStiffness& b) {
    return a += b;
  }
  friend SurfaceStiffness operator*(double factor, SurfaceStiffness m) { return m *= factor; }

  /// The matrix of the bending energy over (w_uu, w_uv, w_vv).
  Mat3 bending() const;
  /// Whether all is finite, and alpha and bending() are positive semi-definite to 1e-12 of their
  /// size.
  bool is_valid() const;
};

/// One triangle of one kind. Cheap to make (no allocation).
class C1Triangle {
 public:
  C1Triangle(TriangleElement kind, const TriangleShape& shape) : kind_(kind), shape_(shape) {}

  const TriangleShape& shape() const { return shape_; }

  /// The 12 functions and their derivatives at barycentric L (sum 1, each in [0, 1]).
  /// HCT second derivatives on a spoke are those of one side; at the centroid, of the sub-triangle
  /// opposite V1. Z12 second derivatives at a vertex are those on approach along the bisecting
  /// direction ρ = L_j/(L_j+L_k) = 1/2.
  Tabulation evaluate(const Vec3& L) const;
  /// The function with dofs q (12 × 3) and its derivatives at L: qᵀ evaluate(L), in half of its
  /// time.
  Eigen::Matrix<double, 3, kDerivatives> jet(const Vec3& L,
                                             const Eigen::Matrix<double, 12, 3>& q) const;

  /// Stiffness for constant coefficients, exact to rounding: nine reference tensors and the matrix
  /// P, no quadrature (about 0.3 µs).
  Mat12 stiffness(const SurfaceStiffness& material) const;

  /// Mass ∬ N Nᵀ and load ∬ N, exact.
  Mat12 mass() const;
  Vec12 load() const;

  /// Integral rule for coefficients and loads that vary: HCT degree 4 on each sub-triangle (exact
  /// for bending with quadratic, stretching with constant coefficients), Z12 six-Duffy with m = 5
  /// (8e-7).
  static const TriangleRule& varying_rule(TriangleElement kind);

  /// Bézier ordinates of the three cubics of the HCT triangle for dofs q (12 x any number of
  /// coordinates): sub-triangle s = (V_j, V_k, centroid) has 10 rows in the order
  /// 300 030 003 210 120 021 012 102 201 111.
  /// Throws InputError for Z12, which is not polynomial.
  Eigen::Matrix<double, 10, 3> bezier(int sub, const Eigen::Matrix<double, 12, 3>& q) const;

  /// The matrix P with q̂ = P q.
  Mat12 to_reference_dofs() const;

 private:
  // Derivatives of the reference functions with respect to (u, v).
  Tabulation reference_at(const Vec3& L) const;
  TriangleElement kind_;
  TriangleShape shape_;
};

}  // namespace batten
