// Terms of the variation of curvature and their derivatives, element by element. Internal.
//
// Every triangle is looked at in its own barycentric coordinates (L1, L2): the terms are geometric,
// so that the tables of functions are the same for all triangles.
#pragma once

#include <array>
#include <vector>

#include "batten/fairing/minimum_variation/curvature_variation.h"
#include "batten/fairing/minimum_variation/join_point.h"
#include "batten/fem/surface.h"

namespace batten {

inline constexpr int kEdgeDofs = 17, kJoinDofs = 24;

/// Residuals of one element and their derivatives by its dofs, [x; y; z] one after the other: column
/// k holds the derivatives of all residuals by dof k.
template <int unknowns, int most_rows>
struct ElementResiduals {
  static constexpr int most = most_rows;
  static_assert(most % 8 == 0);
  alignas(64) double J[unknowns][most];
  alignas(64) double r[most];
  int count = 0;
};
/// Nine points with eight residuals and nine of the step, six of spokes, nine of twist.
using TriangleResiduals = ElementResiduals<36, 168>;
using EdgeResiduals = ElementResiduals<3 * kEdgeDofs, 8>;
using JoinResiduals = ElementResiduals<3 * kJoinDofs, 8>;

/// What is added to JᵀJ so that steps stay small: weights of |δX_ab|² along the frame, over area².
struct DampingWeights {
  double normal = 0;      ///< of its part along the surface's normal
  double tangential = 0;  ///< of the rest: how (u, v) runs over the shape
};

/// The functional over one mesh. Frames and weights are those of the last set_frames(). Values may
/// be asked for any dofs, derivatives for the surface of set_frames() only.
class CurvatureVariationTerms {
 public:
  /// `frozen`: triangles that count nothing, nor the edges beside them. Throws InputError where the
  /// others have no normal.
  CurvatureVariationTerms(const Surface& start, double gauss, double jumps,
                          const std::vector<char>& frozen = {});
  /// Resists twist along a side of the outline: 3/√area ∫ τ² ds, as far as the normal of `start`
  /// does not turn about the side as a whole and its curvature is constant.
  void add_side(const Surface& start, const std::vector<int>& vertices);

  /// Counts the jumps of curvature at these points as those across element edges, and those of
  /// the tangent plane over the square of the thickness, a hundred times as much. Where the normals of the two parts are
  /// opposite, that of the second is turned.
  void add_joins(const Surface& start, const std::vector<JoinPoint>& points);

  void set_frames(const Surface& surface);

  /// Sum of all squares. Infinite where the surface has no normal.
  double value(const Surface& surface) const;

  /// Overwrites `rows`. The rows of the step have residual zero.
  void triangle(const Surface& surface, int t, const DampingWeights& step,
                TriangleResiduals& rows) const;
  void edge(const Surface& surface, int e, EdgeResiduals& rows) const;

  /// Interior edges, and the dofs of one coordinate of each: those of its first triangle, then
  /// those that only the second has.
  const std::vector<int>& edges() const { return edges_; }
  static std::array<int, kEdgeDofs> edge_dofs(const Surface& surface, int e);

  /// Points of joins, and the dofs of one coordinate of each: those of the triangle on the first
  /// side, then those on the second.
  int join_count() const { return isize(joins_); }
  std::array<int, kJoinDofs> join_dofs(const Surface& surface, int j) const;
  void join(const Surface& surface, int j, JoinResiduals& rows) const;
  /// √area of the start.
  double length() const { return length_; }

 private:
  struct Frame {
    Mat2 M;
    double principal;
  };
  // A point: w_u, w_v, w_uu, w_uv, w_vv of the dofs on each side, and the way of the line.
  struct Join {
    std::array<int, 2> triangle;
    std::array<Eigen::Matrix<double, 12, 5>, 2> N;
    std::array<Vec2, 2> direction;
    double weight;
    double sign;  // of the second side's normal, seen from the first
    bool curvature, tangent;
  };
  CurvatureVariationWeights weights_at(int triangle, int point) const;
  double edge_weight(const Surface& surface, int e) const;
  double triangle_value(const Surface& surface, int t) const;
  double edge_value(const Surface& surface, int e) const;
  double join_value(const Surface& surface, const Join& join) const;

  double gauss_, jumps_, length_ = 1;
  std::vector<double> weights_;  // of each triangle, what counts
  std::vector<int> edges_;
  std::vector<Join> joins_;
  std::vector<Frame> frames_;  // nine of each triangle
  std::vector<Vec3> twists_;   // weight of twist on the edges of each triangle, or 0
};

}  // namespace batten
