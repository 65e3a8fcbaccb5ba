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
#include "batten/elements/reference_triangle.h"

namespace batten {

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
  /// The function with dofs q (12 × 3) at L, and with its derivatives: qᵀ evaluate(L), in a fifth
  /// and in two thirds of its time.
  Vec3 position(const Vec3& L, const Eigen::Matrix<double, 12, 3>& q) const;
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
  static const TriangleRule& default_quadrature(TriangleElement kind);

  /// Bézier ordinates of the three cubics of the HCT triangle for dofs q (12 x any number of
  /// coordinates): sub-triangle s = (V_j, V_k, centroid) has 10 rows in the order
  /// 300 030 003 210 120 021 012 102 201 111.
  /// Throws InputError for Z12, which is not polynomial.
  Eigen::Matrix<double, 10, 3> bezier(int sub, const Eigen::Matrix<double, 12, 3>& q) const;

  /// The matrix P with q̂ = P q, and q̂.
  Mat12 pull_back_matrix() const;
  Eigen::Matrix<double, 12, 3> pull_back(const Eigen::Matrix<double, 12, 3>& q) const;

 private:
  // Derivatives of the reference functions with respect to (u, v).
  Tabulation reference_at(const Vec3& L) const;
  TriangleElement kind_;
  TriangleShape shape_;
};

}  // namespace batten
