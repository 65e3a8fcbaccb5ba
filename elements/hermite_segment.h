// SPDX-License-Identifier: MPL-2.0
// Cubic Hermite segment: the element of deformable curves.
//
//      w, w_u                                w, w_u
//        o───────────────────────────────────o          parametric length h, s = u/h in [0, 1]
//       dof 0, 1                            dof 2, 3
//
//   H = (1-3s²+2s³,  h(s-2s²+s³),  3s²-2s³,  h(s³-s²))
//
// The energy of one coordinate is E = ∫ ½ (alpha w_u² + beta w_uu²) - f w du = ½ qᵀK q - Fᵀq, so
// that K q = F at the minimum. Reference: [Celniker1991], section 4 (including the printed
// matrices).
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// A cubic Hermite finite element on a curve segment, with the element matrices of one coordinate
/// w(u). The four dofs are w and w_u at the start of the segment, then w and w_u at its end. The
/// matrices are symmetric and are computed in closed form, in a few nanoseconds.
class HermiteSegment {
 public:
  using Vector = Eigen::Vector4d;
  using Matrix = Eigen::Matrix4d;
  /// A stiffness or load that varies linearly from `start` to `end` of a segment.
  struct Linear {
    double start = 0, end = 0;
    Linear(double both) : start(both), end(both) {}  // NOLINT: a constant is a linear function
    Linear(double s, double e) : start(s), end(e) {}
  };

  /// Creates a segment of length `h` in the curve parameter u. Throws InputError unless h > 0.
  explicit HermiteSegment(double h);

  double length() const { return h_; }
  /// The four shape functions, or their derivatives of the given `order` (0 to 3) with respect to
  /// the curve parameter u, at the position s along the segment (0: start, 1: end). Throws
  /// InputError for other orders.
  Vector evaluate(double s, int order = 0) const;
  /// Stretching stiffness matrix ∫ alpha H_u H_uᵀ du of the four shape functions H, exact for
  /// linear alpha. It is singular, since a constant function has no stretching energy.
  Matrix stretching(Linear alpha = 1) const;
  /// Bending stiffness matrix ∫ beta H_uu H_uuᵀ du of the four shape functions H, exact for linear
  /// beta. It is singular, since a linear function has no bending energy.
  Matrix bending(Linear beta = 1) const;
  /// Mass matrix ∫ H Hᵀ du of the four shape functions H. It is positive definite.
  Matrix mass() const;
  /// Load vector ∫ f H du of a distributed force f; H: shape functions. Exact for linear f.
  Vector load(Linear f = 1) const;

 private:
  double h_;
};

}  // namespace batten
