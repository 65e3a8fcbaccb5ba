#include "batten/skinning/region/surface_interpolation.h"

#include "batten/core/parallel_chunks.h"

namespace batten {

Points interpolate_surface(const ParametricMesh& mesh,
                           const std::function<FirstOrderJet(const Vec2& uv)>& surface,
                           Points* edge_midpoints) {
  if (edge_midpoints) edge_midpoints->resize(mesh.edge_count(), 3);
  const DofMap map(mesh);
  Points q(map.count(), 3);
  parallel_for_each<16>(mesh.vertex_count(), [&](int v) {
    const FirstOrderJet s = surface(mesh.vertices()[v]);
    q.row(map.vertex(v)) = s.x;
    q.row(map.vertex(v, 1)) = s.gradient.col(0);
    q.row(map.vertex(v, 2)) = s.gradient.col(1);
  });
  parallel_for_each<16>(mesh.edge_count(), [&](int e) {
    const auto& edge = mesh.edges()[e];
    const auto& corner = mesh.shape(edge.triangle[0]).vertex;
    const int i = edge.local[0];
    const Vec2 middle = (corner[(i + 1) % 3] + corner[(i + 2) % 3]) / 2;
    const FirstOrderJet s = surface(middle);
    q.row(map.edge(e)) = s.gradient * mesh.edge_normal(e);
    if (edge_midpoints) edge_midpoints->row(e) = s.x;
  });
  return q;
}

}  // namespace batten
