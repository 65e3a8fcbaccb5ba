#include "batten/fem/surface_transfer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "batten/core/parallel_chunks.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

// What the new mesh has in common with the old one: its number there, or -1.
struct SharedEntities {
  std::vector<int> vertex, edge;
  std::vector<char> triangle;

  SharedEntities(const ParametricMesh& from, const ParametricMesh& to)
      : vertex(to.vertex_count(), -1), edge(to.edge_count(), -1), triangle(to.triangle_count(), 0) {
    std::vector<std::pair<std::pair<double, double>, int>> places;
    for (int v = 0; v < from.vertex_count(); ++v)
      places.push_back({{from.vertices()[v].x(), from.vertices()[v].y()}, v});
    std::sort(places.begin(), places.end());
    for (int v = 0; v < to.vertex_count(); ++v) {
      const std::pair<double, double> place{to.vertices()[v].x(), to.vertices()[v].y()};
      const auto found = std::lower_bound(places.begin(), places.end(), std::pair{place, 0});
      if (found != places.end() && found->first == place) vertex[v] = found->second;
    }
    for (int e = 0; e < to.edge_count(); ++e) {
      const int low = vertex[to.edges()[e].low], high = vertex[to.edges()[e].high];
      if (low >= 0 && high >= 0) edge[e] = from.edge_between(low, high);
    }
    for (int t = 0; t < to.triangle_count(); ++t) {
      const int first = edge[to.edges_of(t)[0]], opposite = vertex[to.triangles()[t][0]];
      if (first < 0 || opposite < 0) continue;
      for (const int old : from.edges()[first].triangle)
        if (old >= 0)
          for (const int v : from.triangles()[old]) triangle[t] |= v == opposite;
    }
  }
};

// By how much each new triangle lies off the old surface, at six points.
std::vector<double> displacements(const Surface& from, const ParametricMesh& to,
                                  const SharedEntities& shared, const TriangleLocator& locator,
                                  const Points& new_dofs) {
  // The centroids of the three sub-triangles, and points between those and the edges' middles.
  static const TriangleRule samples = [] {
    TriangleRule points{Points(6, 3), VecX::Constant(6, 1.0 / 6)};
    for (int i = 0; i < 3; ++i) {
      points.L.row(i) = Vec3::Constant(4.0 / 9);
      points.L.row(3 + i) = Vec3::Constant(0.35);
      points.L(i, i) = 1.0 / 9;
      points.L(3 + i, i) = 0.3;
    }
    return points;
  }();
  const DofMap dofs(to);
  const TabulatedRule tabulated(from.kind(), samples);
  std::vector<double> displacement(to.triangle_count(), 0);
  parallel_for_each<256>(to.triangle_count(), [&](int t) {
    if (shared.triangle[t]) return;
    const TriangleShape shape = to.shape(t);
    Eigen::Matrix<double, 12, 3> q;
    const auto dof = dofs.triangle(to, t);
    for (int a = 0; a < 12; ++a) q.row(a) = new_dofs.row(dof[a]);
    q = C1Triangle(from.kind(), shape).pull_back(q);
    for (size_t p = 0; p < tabulated.functions.size(); ++p) {
      const Vec3 x = q.transpose() * tabulated.functions[p].col(0);
      const Vec2 uv = shape.point(samples.L.row(static_cast<long>(p)));
      displacement[t] = std::max(displacement[t], (x - from.position(locator.locate(uv))).norm());
    }
  });
  return displacement;
}

}  // namespace

SurfaceTransfer interpolate_onto(const Surface& from, const ParametricMesh& to) {
  const TriangleLocator locator(from.mesh());
  const SharedEntities shared(from.mesh(), to);
  const DofMap dofs(to);
  SurfaceTransfer result{Points::Zero(dofs.count(), 3)};
  parallel_for_each<256>(to.vertex_count(), [&](int v) {
    if (const int old = shared.vertex[v]; old >= 0) {
      result.dofs.middleRows<3>(dofs.vertex(v)) =
          from.dofs().middleRows<3>(from.dof_map().vertex(old));
      return;
    }
    const SurfaceJet jet = from.jet(locator.locate(to.vertices()[v]));
    result.dofs.row(dofs.vertex(v)) = jet.x;
    result.dofs.row(dofs.vertex(v, 1)) = jet.x_u;
    result.dofs.row(dofs.vertex(v, 2)) = jet.x_v;
  });
  parallel_for_each<256>(to.edge_count(), [&](int e) {
    const auto& edge = to.edges()[e];
    if (const int old = shared.edge[e]; old >= 0) {
      // The normal goes with the direction from the lower number to the higher.
      const double sign = shared.vertex[edge.low] < shared.vertex[edge.high] ? 1 : -1;
      result.dofs.row(dofs.edge(e)) = sign * from.dofs().row(from.dof_map().edge(old));
      return;
    }
    const TriangleShape shape = to.shape(edge.triangle[0]);
    const int i = edge.local[0];
    const Vec2 middle = 0.5 * (shape.vertex[(i + 1) % 3] + shape.vertex[(i + 2) % 3]);
    const Vec2 n = to.edge_normal(e);
    const SurfaceJet jet = from.jet(locator.locate(middle));
    result.dofs.row(dofs.edge(e)) = n.x() * jet.x_u + n.y() * jet.x_v;
  });

  const std::vector<double> displacement = displacements(from, to, shared, locator, result.dofs);
  for (const double m : displacement)
    result.max_displacement = std::max(result.max_displacement, m);
  return result;
}

}  // namespace batten
