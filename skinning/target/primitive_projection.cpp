// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/target/primitive_projection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "batten/core/parallel.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface.h"

namespace batten {

PrimitiveProjection project_onto(const FittedPrimitive& primitive, const Vec3& x) {
  using Kind = FittedPrimitive::Kind;
  constexpr double least = 1e-12;  // of the radii: avoids a division by zero
  const Vec3 q = x - primitive.origin;
  const Vec3 off = q - q.dot(primitive.axis) * primitive.axis;
  const double radius = std::max(primitive.radius + primitive.major_radius, 1e-300);
  const double rho = std::max(off.norm(), least * radius);
  const Vec3 out = off.norm() > least * radius ? Vec3(off / off.norm())
                                               : primitive.axis.unitOrthogonal();
  const Vec3 around = primitive.axis.cross(out);
  const Vec3 n = primitive.normal(x);
  const double d = primitive.distance(x);
  double along_meridian = 0, along_circle = n.dot(out) / rho;  // curvatures of the parallel surface
  switch (primitive.kind) {
    case Kind::Sphere:
      along_meridian = along_circle = 1 / std::max(q.norm(), least * radius);
      break;
    case Kind::Torus:
      along_meridian = 1 / std::max(primitive.radius + d, least * radius);
      break;
    case Kind::Cylinder:
    case Kind::Cone:
      break;
    default:
      along_circle = 0;
  }
  const bool at_apex = primitive.kind == Kind::Cone && off.norm() <= least * radius;
  if (at_apex) return {x - d * n, n, Mat3::Identity()};
  const Vec3 meridian = n.cross(around);
  return {x - d * n, n,
          Mat3::Identity() - n * n.transpose() -
              d * (along_circle * around * around.transpose() +
                   along_meridian * meridian * meridian.transpose())};
}

Points primitive_dofs(const ModelLayout& layout, const Points& dofs,
                      const std::vector<const TargetSurface*>& targets) {
  const ParametricMesh& mesh = *layout.mesh();
  const DofMap map(mesh);
  const Surface surface = layout.surface(dofs);
  std::vector<int> region_of(mesh.vertex_count());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int v : mesh.triangles()[t]) region_of[v] = layout.region_of(t);
  Points wanted = dofs;
  parallel_for_each<256>(mesh.vertex_count(), [&](int v) {
    const auto at = [&](int derivative) -> Vec3 { return dofs.row(map.vertex(v, derivative)); };
    const auto projected = project_onto(*targets[region_of[v]]->primitive(), at(0));
    wanted.row(map.vertex(v)) = projected.at;
    for (const int derivative : {1, 2})
      wanted.row(map.vertex(v, derivative)) = projected.slope * at(derivative);
  });
  parallel_for_each<256>(mesh.edge_count(), [&](int e) {
    const auto& edge = mesh.edges()[e];
    const int t = edge.triangle[0];
    const SurfaceJet jet =
        surface.jet({t, Vec3(0.5 * (Vec3::Ones() - Vec3::Unit(edge.local[0])))});
    const Vec2 across = mesh.edge_normal(e);
    const auto projected = project_onto(*targets[layout.region_of(t)]->primitive(), jet.x);
    wanted.row(map.edge(e)) = projected.slope * (across.x() * jet.x_u + across.y() * jet.x_v);
  });
  return wanted;
}

}  // namespace batten
