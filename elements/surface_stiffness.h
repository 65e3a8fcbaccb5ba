// Resistance of a surface to stretching and bending.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Material of the energy
///
///     E = ∬ (a11 w_u² + 2 a12 w_u w_v + a22 w_v² + b11 w_uu² + 2 b12 w_uv² + b22 w_vv²
///            + 2 m1 w_uu w_uv + 2 m2 w_uu w_vv + 2 m3 w_uv w_vv) du dv,
///
/// beta = (b11, b12, b22), beta_mixed = (m1, m2, m3), zero but for resistance in a direction of its
/// own. Valid: alpha and [[b11 m1 m2], [m1 2 b12 m3], [m2 m3 b22]] positive semi-definite.
/// b11 = b12 = b22 without mixed terms is the rotation-invariant bending energy.
struct SurfaceStiffness {
  Mat2 alpha = Mat2::Zero();
  Vec3 beta = Vec3::Ones();
  Vec3 beta_mixed = Vec3::Zero();

  static SurfaceStiffness isotropic(double alpha, double beta) {
    return {alpha * Mat2::Identity(), Vec3::Constant(beta)};
  }
  /// alpha w_t² + beta w_tt²: resistance in one direction t of (u, v) only. Throws InputError when
  /// t is not of length 1.
  static SurfaceStiffness directional(const Vec2& t, double alpha, double beta);

  SurfaceStiffness& operator+=(const SurfaceStiffness& other);
  SurfaceStiffness& operator*=(double factor);
  friend SurfaceStiffness operator+(SurfaceStiffness a, const SurfaceStiffness& b) {
    return a += b;
  }
  friend SurfaceStiffness operator*(double factor, SurfaceStiffness m) { return m *= factor; }

  /// The matrix of the bending energy over (w_uu, w_uv, w_vv).
  Mat3 bending() const;
  /// Whether all is finite, and alpha and bending() are positive semi-definite to 1e-12 of their
  /// size.
  bool is_valid() const;
};

}  // namespace batten
