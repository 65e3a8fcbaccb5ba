// SPDX-License-Identifier: MPL-2.0
// Cubic Bernstein polynomials on a triangle, and the location of points in the sub-triangles of an
// HCT triangle.
//
//     B_ijk = 3!/(i! j! k!) x^i y^j z^k,  (x, y, z) barycentric,  i + j + k = 3
// Along a direction d in barycentric coordinates (sum 0), the derivative is three times the
// combination of quadratic Bernstein polynomials weighted by d. The second derivative along d and e
// is six times the corresponding combination of linear ones.
#pragma once

#include "batten/core/eigen.h"

namespace batten {

/// Ten values in the order 300 030 003 210 120 021 012 102 201 111.
using BernsteinVector = Eigen::Matrix<double, 10, 1>;

/// Values of the ten cubics at barycentric p.
inline BernsteinVector bernstein_cubics(const Vec3& p) {
  const double x = p[0], y = p[1], z = p[2], xx = x * x, yy = y * y, zz = z * z;
  BernsteinVector B;
  B << xx * x, yy * y, zz * z, 3 * xx * y, 3 * x * yy, 3 * yy * z, 3 * y * zz, 3 * x * zz,
      3 * xx * z, 6 * x * y * z;
  return B;
}

/// First derivatives at p along the barycentric direction d.
inline BernsteinVector bernstein_derivatives(const Vec3& p, const Vec3& d) {
  const double a = 3 * d[0], b = 3 * d[1], c = 3 * d[2];
  const double xx = p[0] * p[0], yy = p[1] * p[1], zz = p[2] * p[2], xy = 2 * p[0] * p[1],
               yz = 2 * p[1] * p[2], zx = 2 * p[2] * p[0];
  BernsteinVector B;
  B << a * xx, b * yy, c * zz, a * xy + b * xx, a * yy + b * xy, b * yz + c * yy, b * zz + c * yz,
      a * zz + c * zx, a * zx + c * xx, a * yz + b * zx + c * xy;
  return B;
}

/// Second derivatives at p along the barycentric directions d and e.
inline BernsteinVector bernstein_derivatives(const Vec3& p, const Vec3& d, const Vec3& e) {
  const double xx = 6 * d[0] * e[0], yy = 6 * d[1] * e[1], zz = 6 * d[2] * e[2],
               xy = 6 * (d[0] * e[1] + d[1] * e[0]), yz = 6 * (d[1] * e[2] + d[2] * e[1]),
               zx = 6 * (d[2] * e[0] + d[0] * e[2]);
  const double x = p[0], y = p[1], z = p[2];
  BernsteinVector B;
  B << xx * x, yy * y, zz * z, xx * y + xy * x, yy * x + xy * y, yy * z + yz * y, zz * y + yz * z,
      zz * x + zx * z, xx * z + zx * x, xy * z + yz * x + zx * y;
  return B;
}

/// Sub-triangle of an HCT triangle that contains a point with barycentric coordinates L.
/// Sub-triangle s has the vertices (V_j, V_k, centroid) and lies opposite V_s. The centroid is
/// assigned to the sub-triangle opposite V1.
struct HctSubtriangle {
  /// Index 0 to 2 of the sub-triangle, and the point's barycentric coordinates in it.
  int sub = 0;
  Vec3 local;

  explicit HctSubtriangle(const Vec3& L) {
    if (L[1] < L[sub]) sub = 1;
    if (L[2] < L[sub]) sub = 2;
    local = to_local(L);
  }
  /// Converts barycentric coordinates of the triangle, or differences of them, to those of the
  /// sub-triangle.
  Vec3 to_local(const Vec3& L) const {
    const double s = L[sub];
    return {L[(sub + 1) % 3] - s, L[(sub + 2) % 3] - s, 3 * s};
  }
};

}  // namespace batten
