// SPDX-License-Identifier: MPL-2.0
// The C1 triangle elements HCT and Z12, with 12 dofs per coordinate.
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
// Edge dofs: the normal derivative w_n = w_u n_u + w_v n_v at the midpoint of each edge, shared by
// both adjacent triangles. t is the unit vector from the end with the LOWER global vertex index to
// the end with the higher one, and n = (-t_v, t_u) is t rotated by +90°. edge_sign[i] = +1 if the
// edge runs along the counter-clockwise direction of its triangle (global(V_j) < global(V_k),
// (i, j, k) cyclic), so that n points into the triangle, and -1 otherwise.
//
//   HCT  Hsieh-Clough-Tocher: three cubics on the sub-triangles (V_j, V_k, centroid). Polynomial,
//        so integrals and conversion to CAD patches are exact. [CloughTocher1965]
//   Z12  Rational triangle of [Celniker1991]: smooth inside, but its second derivatives have no
//        unique value at a vertex (they depend on the direction of approach).
// Both spaces contain all cubics. They are C1 but not C2.
//
// Both elements are implemented in the same way. For the affine-invariant reference dofs
//   q̂ = [w_i, ∂w_i along V_j-V_i, ∂w_i along V_k-V_i] at the vertices and m_i = ∂w along V_i - M_i
//   at the midpoint M_i of edge i,
// the shape functions are fixed functions N̂(L) of the barycentric coordinates. One sparse 12×12
// matrix P, which depends on the shape of the triangle, maps the dofs above: q̂ = P q, so
// N = Pᵀ N̂.
#pragma once

#include <array>

#include "batten/core/eigen.h"
#include "batten/elements/quadrature.h"
#include "batten/elements/reference_triangle.h"

namespace batten {

/// A C1 triangle element (HCT or Z12) with 12 dofs per coordinate. Construction is cheap and
/// allocates no memory.
class C1Triangle {
 public:
  C1Triangle(TriangleElement kind, const TriangleShape& shape) : kind_(kind), shape_(shape) {}

  const TriangleShape& shape() const { return shape_; }

  /// The 12 shape functions and their derivatives up to order two at the barycentric coordinates L
  /// (each in [0, 1], sum 1).
  ///
  /// Second derivatives of the HCT element jump across the segments from the vertices to the
  /// centroid. On such a segment, the value of one side is returned; at the centroid, the value of
  /// the sub-triangle opposite the first vertex. At a vertex, second derivatives of the Z12 element
  /// depend on the direction of approach; the limits along the median are returned.
  Tabulation evaluate(const Vec3& L) const;
  /// Surface point at the barycentric coordinates L for the dofs q (12×3, one column per
  /// coordinate). jet() computes the point and its derivatives up to order two, qᵀ evaluate(L).
  /// Compared with evaluate(), position() takes a fifth and jet() two thirds of the time.
  Vec3 position(const Vec3& L, const Eigen::Matrix<double, 12, 3>& q) const;
  Eigen::Matrix<double, 3, kDerivatives> jet(const Vec3& L,
                                             const Eigen::Matrix<double, 12, 3>& q) const;

  /// 12×12 element stiffness matrix of one coordinate for a constant material, exact to rounding.
  /// It is computed from precomputed integrals, without quadrature, in about 0.3 µs.
  Mat12 stiffness(const SurfaceStiffness& material) const;

  /// Mass matrix ∬ N Nᵀ du dv with the 12 shape functions N. load() is the load vector ∬ N du dv of
  /// a uniform unit load. Matrix and vector are exact to rounding.
  Mat12 mass() const;
  Vec12 load() const;

  /// Quadrature rule for stiffness and loads that vary within an element of the given type. HCT: a
  /// rule of degree 4 on each sub-triangle, exact for bending with quadratically varying stiffness
  /// and for stretching with constant stiffness. Z12: six_duffy_rule(5), with a relative error of
  /// 8e-7.
  static const TriangleRule& default_quadrature(TriangleElement kind);

  /// Bézier control points of the cubic on sub-triangle `sub` (0 to 2) of the HCT triangle, for the
  /// dofs q (12×3, one column per coordinate). The vertices of the sub-triangle are the vertices
  /// sub + 1 and sub + 2 (modulo 3) of the triangle and its centroid. The 10 rows are in the order
  /// 300 030 003 210 120 021 012 102 201 111. Throws InputError for Z12, which is not polynomial.
  Eigen::Matrix<double, 10, 3> bezier(int sub, const Eigen::Matrix<double, 12, 3>& q) const;

  /// Matrix P that maps the dofs q of this triangle to reference dofs P q, which contain
  /// derivatives along edges and medians instead of u and v. pull_back() computes P q.
  Mat12 pull_back_matrix() const;
  Eigen::Matrix<double, 12, 3> pull_back(const Eigen::Matrix<double, 12, 3>& q) const;

 private:
  // Reference shape functions at the barycentric coordinates L, with derivatives in (u, v).
  Tabulation reference_at(const Vec3& L) const;
  TriangleElement kind_;
  TriangleShape shape_;
};

}  // namespace batten
