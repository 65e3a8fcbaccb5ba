#include "batten/io/cad/face_samples.h"

namespace batten {

std::vector<Vec2> points_of_region(const FaceMaker& made) {
  const ParametricMesh& mesh = made.region().surface.mesh();
  const double per_triangle = 6.0 * made.cells() / mesh.triangle_count();
  const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(per_triangle))), 3, 24);
  std::vector<Vec2> points;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
        const Vec2 uv = shape.point({a, b, 1 - a - b});
        if (made.boundary().contains(uv)) points.push_back(uv);
      }
  }
  return points;
}

}  // namespace batten
