// SPDX-License-Identifier: MPL-2.0
// Bilinear map of a rectangle onto a quadrilateral.
#pragma once

#include <Eigen/LU>
#include <array>

#include "batten/core/eigen.h"

namespace batten {

/// Maps the rectangle [0, width] × [0, height] onto the quadrilateral with corners c0, c1, c2, c3,
/// counted around it. With s and t scaled to [0, 1],
///
///     x(s, t) = (1 - t) ((1 - s) c0 + s c1) + t ((1 - s) c3 + s c2)
///
/// Sides are mapped affinely to sides. The map has an inverse if the quadrilateral is convex.
class BilinearMap {
 public:
  /// `extent`: width and height of the rectangle, above 0.
  explicit BilinearMap(const std::array<Vec2, 4>& corners, const Vec2& extent = Vec2::Ones())
      : corners_(corners), extent_(extent) {}

  const Vec2& corner(int k) const { return corners_[k]; }  ///< k = 0 … 3, of the quadrilateral
  const Vec2& extent() const { return extent_; }

  /// Image of a point; defined outside of the rectangle, too.
  Vec2 at(const Vec2& p) const {
    const double s = p[0] / extent_[0], t = p[1] / extent_[1];
    return (1 - t) * ((1 - s) * corners_[0] + s * corners_[1]) +
           t * ((1 - s) * corners_[3] + s * corners_[2]);
  }
  /// Derivatives of at(): column j by component j of p.
  Mat2 jacobian(const Vec2& p) const {
    const double s = p[0] / extent_[0], t = p[1] / extent_[1];
    Mat2 slopes;
    slopes.col(0) =
        ((1 - t) * (corners_[1] - corners_[0]) + t * (corners_[2] - corners_[3])) / extent_[0];
    slopes.col(1) =
        ((1 - s) * (corners_[3] - corners_[0]) + s * (corners_[2] - corners_[1])) / extent_[1];
    return slopes;
  }
  /// The point whose image is x, by Newton's method from the middle of the rectangle.
  Vec2 inverse(const Vec2& x) const {
    Vec2 p = 0.5 * extent_;
    for (int round = 0; round < 10; ++round) {
      const Vec2 step = jacobian(p).inverse() * (x - at(p));
      p += step;
      if (step.cwiseQuotient(extent_).squaredNorm() < 1e-28) break;
    }
    return p;
  }

 private:
  std::array<Vec2, 4> corners_;
  Vec2 extent_;
};

}  // namespace batten
