// The cubic Hermite segment: the deformable curve element.
//
//      w, w_u                                w, w_u
//        o───────────────────────────────────o          parametric length h, s = u/h in [0, 1]
//       dof 0, 1                            dof 2, 3
//
//   H = (1-3s²+2s³,  h(s-2s²+s³),  3s²-2s³,  h(s³-s²))
//
// Energy of one coordinate, E = ∫ (alpha w_u² + beta w_uu² - 2 f w) du = qᵀK q - 2 Fᵀq, so that
// K q = F at the minimum. Source: Celniker and Gossard 1991, section 4 (its printed matrices).
#pragma once

#include "batten/core/eigen.h"

namespace batten {

class HermiteSegment {
 public:
  using Vector = Eigen::Vector4d;
  using Matrix = Eigen::Matrix4d;
  /// A coefficient with one value at each end, linear in between.
  struct Linear {
    double start = 0, end = 0;
    Linear(double both) : start(both), end(both) {}  // NOLINT: a constant is a linear function
    Linear(double s, double e) : start(s), end(e) {}
  };

  /// h > 0: parametric length. Throws InputError otherwise.
  explicit HermiteSegment(double h);

  double length() const { return h_; }
  /// The four functions, or their derivative of `order` 0 to 3 with respect to u, at s = u/h.
  Vector evaluate(double s, int order = 0) const;
  /// Stiffness ∫ alpha H_u H_uᵀ du, exact for linear alpha.
  Matrix stretching(Linear alpha = 1) const;
  /// Stiffness ∫ beta H_uu H_uuᵀ du, exact for linear beta.
  Matrix bending(Linear beta = 1) const;
  /// Mass ∫ H Hᵀ du.
  Matrix mass() const;
  /// Load ∫ f H du, exact for linear f.
  Vector load(Linear f = 1) const;

 private:
  double h_;
};

}  // namespace batten
