// SPDX-License-Identifier: MPL-2.0
// Square grids that are not aligned with a curve, for embedded curves.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface.h"

namespace batten_test {

using namespace batten;

using std::numbers::pi;

/// The C1 cubic spline with n segments through a function t → (position for order 0, derivative for
/// order 1).
inline HermiteCurve hermite(double start, double end, int n, bool closed,
                            const std::function<Vec3(double t, int order)>& f) {
  std::vector<double> u;
  for (int i = 0; i <= n; ++i) u.push_back(start + (end - start) * i / n);
  const CurveMesh mesh(u, closed);
  Points dofs(mesh.dof_count(), 3);
  for (int i = 0; i < mesh.node_count(); ++i) {
    dofs.row(mesh.position_dof(i)) = f(u[static_cast<size_t>(i)], 0);
    dofs.row(mesh.slope_out(i)) = f(u[static_cast<size_t>(i)], 1);
  }
  return {mesh, dofs};
}

/// Circle in (u, v), z = 0.
inline HermiteCurve circle(const Vec2& centre, double radius, int n, bool clockwise = false) {
  const double s = clockwise ? -1 : 1;
  return hermite(0, 2 * pi, n, true, [=](double t, int order) {
    return order == 0
               ? Vec3(centre.x() + radius * std::cos(t), centre.y() + s * radius * std::sin(t), 0)
               : Vec3(-radius * std::sin(t), s * radius * std::cos(t), 0);
  });
}

/// columns × rows squares of side h, each cut along its diagonal from (0,0) to (1,1).
inline ParametricMesh squares(const Vec2& origin, double h, int columns, int rows) {
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) vertices.push_back(origin + h * Vec2(i, j));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  return {vertices, triangles};
}

/// The triangles of a mesh that contain a part of the region, and their trim.
struct EmbeddedGrid {
  std::shared_ptr<const ParametricMesh> mesh;
  std::shared_ptr<const Trim> trim;
  std::shared_ptr<const TriangleLocator> locator;

  EmbeddedGrid(const ParametricMesh& grid, const DomainLoops& loops) {
    const Trim whole(grid, loops);
    std::vector<int> kept, renumbered(grid.vertex_count(), -1);
    std::vector<Vec2> vertices;
    std::vector<ParametricMesh::Triangle> triangles;
    for (int t = 0; t < grid.triangle_count(); ++t) {
      if (whole.side(t) == Trim::Side::Outside) continue;
      kept.push_back(t);
      ParametricMesh::Triangle triangle = grid.triangles()[t];
      for (int& v : triangle) {
        if (renumbered[v] < 0) {
          renumbered[v] = static_cast<int>(vertices.size());
          vertices.push_back(grid.vertices()[v]);
        }
        v = renumbered[v];
      }
      triangles.push_back(triangle);
    }
    mesh = std::make_shared<ParametricMesh>(vertices, triangles);
    trim = std::make_shared<Trim>(whole.restricted(kept));
    locator = std::make_shared<TriangleLocator>(*mesh);
  }
};

}  // namespace batten_test
