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

/// One cubic Hermite segment with its element matrices for one coordinate w. Dofs: the value w and
/// the derivative w_u at s = 0, then both at s = 1. Matrices are symmetric and are computed in
/// closed form, without quadrature, in a few nanoseconds.
class HermiteSegment {
 public:
  using Vector = Eigen::Vector4d;
  using Matrix = Eigen::Matrix4d;
  /// Coefficient that varies linearly between its values at s = 0 (`start`) and s = 1 (`end`).
  struct Linear {
    double start = 0, end = 0;
    Linear(double both) : start(both), end(both) {}  // NOLINT: a constant is a linear function
    Linear(double s, double e) : start(s), end(e) {}
  };

  /// `h`: parametric length of the segment, in units of u. Throws InputError unless h > 0.
  explicit HermiteSegment(double h);

  double length() const { return h_; }
  /// The four shape functions, or their derivatives of the given `order` (0 to 3) with respect to
  /// u, at s = u/h in [0, 1]. Throws InputError for another order.
  Vector evaluate(double s, int order = 0) const;
  /// Stretching stiffness ∫ alpha H_u H_uᵀ du with the shape functions H, exact for linear alpha.
  /// Singular: a constant w has no energy.
  Matrix stretching(Linear alpha = 1) const;
  /// Bending stiffness ∫ beta H_uu H_uuᵀ du with the shape functions H, exact for linear beta.
  /// Singular: a linear w has no energy.
  Matrix bending(Linear beta = 1) const;
  /// Mass matrix ∫ H Hᵀ du with the shape functions H, positive definite.
  Matrix mass() const;
  /// Load vector ∫ f H du of a distributed force f with the shape functions H, exact for linear f.
  Vector load(Linear f = 1) const;

 private:
  double h_;
};

}  // namespace batten
