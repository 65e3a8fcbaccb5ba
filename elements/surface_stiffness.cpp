#include "batten/elements/surface_stiffness.h"

#include <cmath>

#include "batten/core/dense.h"
#include "batten/core/errors.h"

namespace batten {

SurfaceStiffness SurfaceStiffness::directional(const Vec2& t, double alpha, double beta) {
  constexpr double unit = 1e-9;
  if (!(std::abs(t.norm() - 1) <= unit))
    throw InputError("a direction (" + format_number(t.x()) + ", " + format_number(t.y()) +
                     ") of length " + format_number(t.norm()) +
                     ": resistance wants a direction of length 1");
  // w_tt = a w_uu + 2 b w_uv + c w_vv.
  const double a = t.x() * t.x(), b = t.x() * t.y(), c = t.y() * t.y();
  return {alpha * t * t.transpose(), beta * Vec3(a * a, 2 * b * b, c * c),
          beta * Vec3(2 * a * b, a * c, 2 * b * c)};
}

SurfaceStiffness& SurfaceStiffness::operator+=(const SurfaceStiffness& other) {
  alpha += other.alpha;
  beta += other.beta;
  beta_mixed += other.beta_mixed;
  return *this;
}

SurfaceStiffness& SurfaceStiffness::operator*=(double factor) {
  alpha *= factor;
  beta *= factor;
  beta_mixed *= factor;
  return *this;
}

Mat3 SurfaceStiffness::bending() const {
  Mat3 B;
  B << beta[0], beta_mixed[0], beta_mixed[1],     //
      beta_mixed[0], 2 * beta[1], beta_mixed[2],  //
      beta_mixed[1], beta_mixed[2], beta[2];
  return B;
}

bool SurfaceStiffness::is_valid() const {
  if (!alpha.allFinite() || !beta.allFinite() || !beta_mixed.allFinite()) return false;
  constexpr double rounding = 1e-12;
  const Mat3 B = bending();
  return alpha.isApprox(alpha.transpose()) &&
         symmetric_eigenvalues(alpha)[0] >= -rounding * alpha.norm() &&
         symmetric_eigenvalues(B)[0] >= -rounding * B.norm();
}

}  // namespace batten
