// Terms of the variation of curvature and their derivatives, element by element. Internal.
//
// Every triangle is looked at in its own barycentric coordinates (L1, L2): the terms are geometric,
// so that the tables of functions are the same for all triangles.
#pragma once

#include <array>
#include <vector>

#include "batten/fairing/curvature_change.h"
#include "batten/fem/surface.h"

namespace batten {

inline constexpr int kTriangleUnknowns = 36, kEdgeDofs = 17, kEdgeUnknowns = 51;

/// Σ r², JᵀJ and Jᵀr of one element, unknowns [x; y; z] of its dofs.
template <int unknowns>
struct SquaredTerms {
  double value = 0;
  Eigen::Matrix<double, unknowns, unknowns> normal;
  Eigen::Matrix<double, unknowns, 1> gradient;
};
using TriangleTerms = SquaredTerms<kTriangleUnknowns>;
using EdgeTerms = SquaredTerms<kEdgeUnknowns>;

/// What is added to JᵀJ so that steps stay small: per |δX_ab|² along the frame, over area².
struct StepWeights {
  double evenness;  ///< e, of the tangential part: how (u, v) runs over the shape
  double damping;   ///< λ, of all of it
};

/// The functional over one mesh. Frames and weights are those of the last set_frames(). Values may
/// be asked for any dofs, derivatives for the surface of set_frames() only.
class VariationTerms {
 public:
  /// Throws InputError where the surface has no normal.
  VariationTerms(const Surface& start, double gauss, double jumps);
  /// Resists twist along a side of the outline: 3/√area ∫ τ² ds, as far as the normal of `start`
  /// does not turn about the side as a whole and its curvature is constant.
  void add_side(const Surface& start, const std::vector<int>& vertices);

  void set_frames(const Surface& surface);

  /// Sum of all squares. Infinite where the surface has no normal.
  double value(const Surface& surface) const;

  TriangleTerms triangle(const Surface& surface, int t, const StepWeights& step) const;
  EdgeTerms edge(const Surface& surface, int e) const;

  /// Interior edges, and the dofs of one coordinate of each: those of its first triangle, then
  /// those that only the second has.
  const std::vector<int>& edges() const { return edges_; }
  static std::array<int, kEdgeDofs> edge_dofs(const Surface& surface, int e);
  /// √area of the start.
  double length() const { return length_; }

 private:
  struct Frame {
    Mat2 M;
    double principal;
  };
  ChangeWeights weights_at(int triangle, int point) const;
  // Of a trimmed surface only the part inside counts.
  static double share(const Surface& surface, int t);
  static double share_beside(const Surface& surface, int e);
  double triangle_value(const Surface& surface, int t) const;
  double edge_value(const Surface& surface, int e) const;

  double gauss_, jumps_, length_ = 1;
  std::vector<int> edges_;
  std::vector<Frame> frames_;  // nine of each triangle
  std::vector<Vec3> twists_;   // weight of twist on the edges of each triangle, or 0
};

}  // namespace batten
