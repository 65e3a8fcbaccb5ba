#include "batten/skinning/region/surface_dofs.h"

#include "batten/core/chunks.h"

namespace batten {

Points interpolated(const ParametricMesh& mesh,
                    const std::function<SurfaceSlope(const Vec2& uv)>& surface, Points* middles) {
  if (middles) middles->resize(mesh.edge_count(), 3);
  const DofMap map(mesh);
  Points q(map.count(), 3);
  for_each_in_chunks<16>(mesh.vertex_count(), [&](int v) {
    const SurfaceSlope s = surface(mesh.vertices()[v]);
    q.row(map.vertex(v)) = s.x;
    q.row(map.vertex(v, 1)) = s.by_uv.col(0);
    q.row(map.vertex(v, 2)) = s.by_uv.col(1);
  });
  for_each_in_chunks<16>(mesh.edge_count(), [&](int e) {
    const auto& edge = mesh.edges()[e];
    const auto& corner = mesh.shape(edge.triangle[0]).vertex;
    const int i = edge.local[0];
    const Vec2 middle = (corner[(i + 1) % 3] + corner[(i + 2) % 3]) / 2;
    const SurfaceSlope s = surface(middle);
    q.row(map.edge(e)) = s.by_uv * mesh.edge_normal(e);
    if (middles) middles->row(e) = s.x;
  });
  return q;
}

}  // namespace batten
