// SPDX-License-Identifier: MPL-2.0
// Elementwise assembly of the minimum-variation functional: residuals of triangles, edges and
// joins, with their Jacobians.
//
// Every triangle is evaluated in its own barycentric coordinates (L1, L2). The terms do not depend
// on the parametrisation, so all triangles share the tables of basis functions.
#pragma once

#include <array>
#include <vector>

#include "batten/fairing/minimum_variation/curvature_variation.h"
#include "batten/fem/surface.h"

namespace batten {

inline constexpr int kEdgeDofs = 17, kJoinDofs = 24;

/// Residuals of one element and their Jacobian with respect to its dofs, ordered [x; y; z]. Column
/// k holds the derivatives of all residuals by dof k.
template <int unknowns, int most_rows>
struct ElementResiduals {
  static constexpr int most = most_rows;
  static_assert(most % 8 == 0);
  alignas(64) double J[unknowns][most];
  alignas(64) double r[most];
  int count = 0;
};
/// Nine points with eight residuals and nine damping terms each, six spoke points, nine twist
/// points.
using TriangleResiduals = ElementResiduals<36, 168>;
using EdgeResiduals = ElementResiduals<3 * kEdgeDofs, 8>;
using JoinResiduals = ElementResiduals<3 * kJoinDofs, 8>;

/// Damping that is added to JᵀJ to keep steps small: weights of |δX_ab|² along the frame, over
/// area².
struct DampingWeights {
  double normal = 0;  ///< weight of the component along the surface normal
  /// Weight of the tangential components, which change only how (u, v) runs over the shape.
  double tangential = 0;
};

/// The minimum-variation functional on one mesh.
///
/// Frames and weights are those of the last set_frames(). Values can be computed for any dofs,
/// derivatives only for the surface of set_frames().
class CurvatureVariationTerms {
 public:
  /// `gauss`, `jumps`: see MinimumVariationOptions. `frozen`: triangles that are ignored, together
  /// with their edges. Throws InputError if the other triangles have a point without a normal.
  CurvatureVariationTerms(const Surface& start, double gauss, double jumps,
                          const std::vector<char>& frozen = {});
  /// Adds a penalty on twist along a side of the boundary, 3/√area ∫ τ² ds. It fades out if the
  /// normal of `start` rotates about the side as a whole or if the curvature of the side is not
  /// constant.
  void add_side(const Surface& start, const std::vector<int>& vertices);

  /// Adds joins: penalties on the jumps across a line between two parts of the surface.
  ///
  /// Jumps of curvature count as those across element edges. Jumps of the tangent plane count a
  /// hundred times as much, over the square of the thickness. If the normals of the two parts are
  /// opposite, that of the second is reversed. The weights at given surfaces are the same.
  void add_joins(const Surface& start, const std::vector<JoinPoint>& points);

  void set_frames(const Surface& surface);

  /// Sum of all squared residuals; infinite if the surface has a point without a normal.
  double value(const Surface& surface) const;

  /// Computes the residuals of triangle t and overwrites `rows`. The damping rows have residual
  /// zero.
  void triangle(const Surface& surface, int t, const DampingWeights& step,
                TriangleResiduals& rows) const;
  void edge(const Surface& surface, int e, EdgeResiduals& rows) const;

  /// Interior edges, and the dofs per coordinate of each: those of its first triangle, then those
  /// that only the second has.
  const std::vector<int>& edges() const { return edges_; }
  static std::array<int, kEdgeDofs> edge_dofs(const Surface& surface, int e);

  /// Points of joins, and the dofs per coordinate of each: those of the triangle on the first side,
  /// then those on the second side.
  int join_count() const { return isize(joins_); }
  std::array<int, kJoinDofs> join_dofs(const Surface& surface, int j) const;
  void join(const Surface& surface, int j, JoinResiduals& rows) const;
  /// Length scale: √area of the start.
  double length() const { return length_; }

 private:
  struct Frame {
    Mat2 M;
    double principal;
  };
  // A join point: w_u, w_v, w_uu, w_uv, w_vv of the dofs on each side, and the direction of the
  // line.
  struct Join {
    std::array<int, 2> triangle;
    std::array<Eigen::Matrix<double, 12, 5>, 2> N;
    std::array<Vec2, 2> direction;
    double weight;
    double sign;  // -1 if the normal of the second side is opposite to that of the first
    bool curvature, tangent;
    std::optional<JoinPoint::Given> given;
  };
  CurvatureVariationWeights weights_at(int triangle, int point) const;
  double edge_weight(const Surface& surface, int e) const;
  double triangle_value(const Surface& surface, int t) const;
  double edge_value(const Surface& surface, int e) const;
  double join_value(const Surface& surface, const Join& join) const;

  double gauss_, jumps_, length_ = 1;
  std::vector<double> weights_;  // area weight of each triangle; 0: ignored
  std::vector<int> edges_;
  std::vector<Join> joins_;
  std::vector<Frame> frames_;  // principal frames; nine per triangle
  std::vector<Vec3> twists_;   // weights of twist on the edges of each triangle; 0: none
};

}  // namespace batten
