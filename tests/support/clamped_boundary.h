// SPDX-License-Identifier: MPL-2.0
// The boundary condition of clamped plates.
#pragma once

#include <vector>

#include "batten/constraints/constraint_set.h"
#include "batten/fem/parametric_mesh.h"

namespace batten_test {

/// Value and gradient are zero on the boundary; every dof is fixed once.
inline batten::ConstraintSet clamped_boundary(const batten::ParametricMesh& mesh) {
  const batten::DofMap dofs(mesh);
  batten::ConstraintSet constraints(dofs.count());
  const auto fix = [&](int dof) { constraints.fix("clamped rim", dof, batten::Vec3::Zero()); };
  std::vector<char> rim(mesh.vertex_count(), 0);
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    if (!edge.boundary()) continue;
    rim[edge.low] = rim[edge.high] = 1;
    fix(dofs.edge(e));
  }
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int d = 0; rim[v] && d < 3; ++d) fix(dofs.vertex(v, d));
  return constraints;
}

}  // namespace batten_test
