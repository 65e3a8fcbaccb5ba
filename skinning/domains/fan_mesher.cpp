#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/op_counter.h"
#include "batten/skinning/domains/mesher.h"

namespace batten {

ParametricMesh fan_mesh(const PlanarMeshInput& task, int refinements) {
  count(OpCounter::Triangulation);
  if (!task.inner.empty() || !task.holes.empty())
    throw InputError("the fan mesher takes no inner lines and no holes: use mesher = \"delaunay\"");
  std::vector<Vec2> vertices = task.points;
  // Centre of area.
  Vec2 centre = Vec2::Zero();
  double area = 0;
  for (const auto& [a, b] : task.outline) {
    const double cross = vertices[a].x() * vertices[b].y() - vertices[a].y() * vertices[b].x();
    area += 0.5 * cross;
    centre += cross / 6 * (vertices[a] + vertices[b]);
  }
  vertices.push_back(centre / area);
  const int middle = isize(vertices) - 1;
  std::vector<ParametricMesh::Triangle> triangles;
  for (const auto& [a, b] : task.outline) {
    const Vec2 p = vertices[a] - vertices[middle], q = vertices[b] - vertices[middle];
    if (!(p.x() * q.y() - p.y() * q.x() > 0))
      throw InputError(
          "the fan mesher needs a domain whose sides are all seen from its centre: use "
          "mesher = \"delaunay\"");
    triangles.push_back({middle, a, b});
  }
  ParametricMesh mesh(std::move(vertices), std::move(triangles));
  for (int r = 0; r < refinements; ++r) mesh = mesh.refined();
  return mesh;
}

}  // namespace batten
