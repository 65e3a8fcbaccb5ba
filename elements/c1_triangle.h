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

/// One C1 triangle element of type `kind`. Construction is cheap and allocates no memory.
class C1Triangle {
 public:
  C1Triangle(TriangleElement kind, const TriangleShape& shape) : kind_(kind), shape_(shape) {}

  const TriangleShape& shape() const { return shape_; }

  /// The 12 shape functions and their derivatives at barycentric L (sum 1, each in [0, 1]).
  ///
  /// HCT second derivatives jump across the segments from the vertices to the centroid. On such a
  /// segment, the value of one side is returned; at the centroid, that of the sub-triangle opposite
  /// V1. Z12 second derivatives at a vertex are the limits along the direction
  /// ρ = L_j/(L_j+L_k) = 1/2, which points to the midpoint of the opposite edge.
  Tabulation evaluate(const Vec3& L) const;
  /// Value at barycentric L of the function with dofs q (12×3). jet() computes the value and all
  /// derivatives up to order two. The results equal qᵀ evaluate(L), but position() takes a fifth
  /// and jet() two thirds of the time.
  Vec3 position(const Vec3& L, const Eigen::Matrix<double, 12, 3>& q) const;
  Eigen::Matrix<double, 3, kDerivatives> jet(const Vec3& L,
                                             const Eigen::Matrix<double, 12, 3>& q) const;

  /// Stiffness matrix for a constant material, exact to rounding. It is computed from nine
  /// precomputed reference tensors and pull_back_matrix(), without quadrature, in about 0.3 µs.
  Mat12 stiffness(const SurfaceStiffness& material) const;

  /// Mass matrix ∬ N Nᵀ du dv, and load() the load vector ∬ N du dv of a unit load, for the shape
  /// functions N. Both are exact to rounding.
  Mat12 mass() const;
  Vec12 load() const;

  /// Quadrature rule for variable coefficients and loads. HCT: degree 4 on each sub-triangle, exact
  /// for bending with quadratic coefficients and for stretching with constant coefficients. Z12:
  /// six-Duffy rule with m = 5 (relative error 8e-7).
  static const TriangleRule& default_quadrature(TriangleElement kind);

  /// Bézier ordinates (control points) of the cubic on sub-triangle `sub` of the HCT triangle, for
  /// dofs q (12×3). Sub-triangle s has the vertices (V_j, V_k, centroid) and 10 rows in the order
  /// 300 030 003 210 120 021 012 102 201 111. Throws InputError for Z12, which is not polynomial.
  Eigen::Matrix<double, 10, 3> bezier(int sub, const Eigen::Matrix<double, 12, 3>& q) const;

  /// Matrix P that maps the dofs q of this triangle to the affine-invariant reference dofs q̂ = P
  /// q. pull_back() computes q̂.
  Mat12 pull_back_matrix() const;
  Eigen::Matrix<double, 12, 3> pull_back(const Eigen::Matrix<double, 12, 3>& q) const;

 private:
  // Reference functions N̂ with their derivatives with respect to (u, v).
  Tabulation reference_at(const Vec3& L) const;
  TriangleElement kind_;
  TriangleShape shape_;
};

}  // namespace batten
