#include "batten/elements/triangle_shape.h"

#include <cmath>

#include "batten/core/errors.h"

namespace batten {

TriangleShape::TriangleShape(const Vec2& v1, const Vec2& v2, const Vec2& v3,
                             const std::array<double, 3>& signs)
    : vertex{v1, v2, v3}, edge_sign(signs) {
  for (int i = 0; i < 3; ++i) {
    const Vec2 &j = vertex[(i + 1) % 3], &k = vertex[(i + 2) % 3];
    b[i] = j.y() - k.y();
    c[i] = k.x() - j.x();
  }
  area = 0.5 * (c[2] * b[1] - c[1] * b[2]);
  if (!(area > 0) || !std::isfinite(area))
    throw MeshError("a parametric triangle of area " + format_number(area) + " at (" +
                    format_number(v1.x()) + ", " + format_number(v1.y()) +
                    "): vertices must run counter-clockwise and not lie on one line");
}

Vec3 TriangleShape::barycentric(const Vec2& p) const {
  Vec3 L;
  for (int i = 0; i < 3; ++i) {
    const Vec2 d = p - vertex[(i + 1) % 3];
    L[i] = (b[i] * d.x() + c[i] * d.y()) / (2 * area);
  }
  return L;
}

}  // namespace batten
