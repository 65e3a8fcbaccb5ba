// SPDX-License-Identifier: MPL-2.0
// Random numbers, meshes and interpolated surfaces for many tests.
#pragma once

#include <memory>
#include <random>

#include "batten/fem/surface.h"

namespace batten_test {

using namespace batten;

constexpr TriangleElement kBothElements[] = {TriangleElement::HCT, TriangleElement::Z12};

inline const char* name(TriangleElement kind) {
  return kind == TriangleElement::HCT ? "HCT" : "Z12";
}

/// The same numbers in [-1, 1) on every machine.
struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double operator()() { return engine() * 0x1p-31 - 1; }
  double between(double low, double high) { return low + (high - low) * engine() * 0x1p-32; }
  Vec3 point() {
    const double x = (*this)(), y = (*this)(), z = (*this)();
    return {x, y, z};
  }
};

/// Largest difference of an entry, relative to the largest entry.
inline double relative_error(const MatX& found, const MatX& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

/// n×n×2 triangles of the unit square, inner vertices moved by up to 20 % of the spacing.
inline ParametricMesh perturbed_square(int n, unsigned seed) {
  const ParametricMesh square = ParametricMesh::unit_square(n);
  Random random(seed);
  std::vector<Vec2> vertices = square.vertices();
  for (Vec2& p : vertices)
    if (p.minCoeff() > 0 && p.maxCoeff() < 1) {
      p.x() += 0.2 / n * random();
      p.y() += 0.2 / n * random();
    }
  return {vertices, square.triangles()};
}

/// Dofs of a function uv → (w, w_u, w_v) of one coordinate.
template <class Function>
VecX dofs_of(const ParametricMesh& mesh, const Function& f) {
  const DofMap dofs(mesh);
  VecX q(dofs.count());
  for (int v = 0; v < mesh.vertex_count(); ++v) q.segment<3>(3 * v) = f(mesh.vertices()[v]);
  for (int e = 0; e < mesh.edge_count(); ++e) {
    const auto& edge = mesh.edges()[e];
    const Vec3 at = f(0.5 * (mesh.vertices()[edge.low] + mesh.vertices()[edge.high]));
    q[dofs.edge(e)] = mesh.edge_normal(e).dot(at.tail<2>());
  }
  return q;
}

/// The surface that interpolates uv → (x, x_u, x_v), or a jet.
template <class Function>
Surface interpolated(std::shared_ptr<const ParametricMesh> mesh, TriangleElement kind,
                     const Function& f) {
  Points q(DofMap(*mesh).count(), 3);
  for (int c = 0; c < 3; ++c)
    q.col(c) = dofs_of(*mesh, [&](const Vec2& p) {
      const auto j = f(p);
      return Vec3(j.x[c], j.x_u[c], j.x_v[c]);
    });
  return Surface(std::move(mesh), kind, std::move(q));
}

}  // namespace batten_test
