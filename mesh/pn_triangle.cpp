#include "batten/mesh/pn_triangle.h"

namespace batten {

PnTriangle::PnTriangle(const Corners& points, const Corners& normals) {
  Vec3 edges = Vec3::Zero(), middle = Vec3::Zero();
  for (size_t c = 0; c < 3; ++c) b_[c] = points[c];
  for (size_t c = 0; c < 3; ++c) {
    const size_t d = (c + 1) % 3;
    const Vec3 &p = points[c], &q = points[d];
    b_[3 + 2 * c] = (2 * p + q - (q - p).dot(normals[c]) * normals[c]) / 3;
    b_[4 + 2 * c] = (2 * q + p - (p - q).dot(normals[d]) * normals[d]) / 3;
    edges += (b_[3 + 2 * c] + b_[4 + 2 * c]) / 6;
    middle += p / 3;
  }
  b_[9] = edges + (edges - middle) / 2;
}

PnTriangle::Jet PnTriangle::jet(const Vec3& w) const {
  const auto mean = [&w](const Vec3& a, const Vec3& b, const Vec3& c) -> Vec3 {
    return w[0] * a + w[1] * b + w[2] * c;
  };
  // De Casteljau's scheme: three quadratic's points a side, then the corners of the tangent plane.
  const Vec3 r00 = mean(b_[0], b_[3], b_[8]), r11 = mean(b_[4], b_[1], b_[5]),
             r22 = mean(b_[7], b_[6], b_[2]), r01 = mean(b_[3], b_[4], b_[9]),
             r12 = mean(b_[9], b_[5], b_[6]), r02 = mean(b_[8], b_[9], b_[7]);
  const Vec3 q0 = mean(r00, r01, r02), q1 = mean(r01, r11, r12), q2 = mean(r02, r12, r22);
  Jet jet;
  jet.x = mean(q0, q1, q2);
  jet.u = 3 * (q1 - q0);
  jet.v = 3 * (q2 - q0);
  jet.uu = 6 * (r11 - 2 * r01 + r00);
  jet.vv = 6 * (r22 - 2 * r02 + r00);
  jet.uv = 6 * (r12 - r01 - r02 + r00);
  return jet;
}

}  // namespace batten
