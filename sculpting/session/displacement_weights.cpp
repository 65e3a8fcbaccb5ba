#include "batten/sculpting/session/displacement_weights.h"

#include <algorithm>
#include <cmath>

namespace batten {

VecX displacement_weights(const ParametricMesh& mesh, const Trim* trim) {
  const DofMap dofs(mesh);
  VecX weights = VecX::Zero(dofs.count());
  constexpr double seen = 0.05;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (trim && trim->area_fraction(t) < seen) continue;
    const double h = std::sqrt(2 * mesh.shape(t).area);
    for (const int v : mesh.triangles()[t]) {
      weights[dofs.vertex(v)] = 1;
      for (const int derivative : {1, 2}) {
        double& w = weights[dofs.vertex(v, derivative)];
        w = std::max(w, h);
      }
    }
    for (const int e : mesh.edges_of(t)) weights[dofs.edge(e)] = std::max(weights[dofs.edge(e)], h);
  }
  return weights;
}

}  // namespace batten
