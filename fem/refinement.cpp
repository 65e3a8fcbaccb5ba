// SPDX-License-Identifier: MPL-2.0
#include "batten/fem/refinement.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/elements/reference_triangle.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

constexpr int kGauss = 3;
using Second = Eigen::Matrix<double, 12, 3>;  // ∂11, ∂12, ∂22 of the reference functions

// Second derivatives along the edges, and along the spokes from either side. Indices:
// [edge i][Gauss point from V_i+1 to V_i+2]; [spoke from V_i][side: sub-triangle i+1,
// i+2][Gauss point from V_i].
struct Tables {
  SegmentRule gauss = gauss_legendre(kGauss);
  Second edge[3][kGauss];
  Second spoke[3][2][kGauss];
  Vec3 on_edge[3][kGauss], on_spoke[3][kGauss];

  explicit Tables(TriangleElement kind) {
    const Vec3 centre = Vec3::Constant(1.0 / 3);
    for (int i = 0; i < 3; ++i)
      for (int g = 0; g < kGauss; ++g) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double s = gauss.s[g];
        on_edge[i][g] = (1 - s) * Vec3::Unit(j) + s * Vec3::Unit(k);
        on_spoke[i][g] = (1 - s) * Vec3::Unit(i) + s * centre;
        edge[i][g] = second(kind, on_edge[i][g]);
        if (kind != TriangleElement::HCT) continue;
        for (const int side : {0, 1}) {
          // Second derivatives are linear in the sub-triangle: extrapolate from two points inside
          // of it, one twice as far in as the other.
          const int sub = (i + 1 + side) % 3;
          const Vec3 inwards =
              (Vec3::Unit((sub + 1) % 3) + Vec3::Unit((sub + 2) % 3) + centre) / 3 - on_spoke[i][g];
          spoke[i][side][g] = 2 * second(kind, on_spoke[i][g] + 0.5 * inwards) -
                              second(kind, on_spoke[i][g] + inwards);
        }
      }
  }

 private:
  static Second second(TriangleElement kind, const Vec3& L) {
    return reference_functions(kind, L).rightCols<3>();
  }
};

const Tables& tables(TriangleElement kind) {
  static const Tables hct(TriangleElement::HCT), z12(TriangleElement::Z12);
  return kind == TriangleElement::HCT ? hct : z12;
}

}  // namespace

VecX residual_indicator(const Surface& surface) {
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  const Tables& table = tables(surface.kind());
  const auto counts = [&](int t, const TriangleShape& shape, const Vec3& L) {
    if (!trim || trim->side(t) == Trim::Side::Inside) return true;
    return trim->side(t) == Trim::Side::Cut && trim->loops().contains(shape.point(L));
  };

  using Along = std::array<Vec3, kGauss>;  // x_uu + x_vv
  std::vector<std::array<Along, 3>> edges(mesh.triangle_count());
  VecX eta = VecX::Zero(mesh.triangle_count());
  parallel_for_each<256>(mesh.triangle_count(), [&](int t) {
    const TriangleShape shape = mesh.shape(t);
    const Eigen::Matrix<double, 12, 3> q =
        C1Triangle(surface.kind(), shape).pull_back(surface.triangle_dofs(t));
    const DerivativeMap map(shape);
    const Vec3 laplacian = (map.second.row(0) + map.second.row(2)).transpose();
    const auto at = [&](const Second& N) -> Vec3 { return q.transpose() * (N * laplacian); };
    for (int i = 0; i < 3; ++i)
      for (int g = 0; g < kGauss; ++g) edges[t][i][g] = at(table.edge[i][g]);
    if (surface.kind() != TriangleElement::HCT) return;
    const Vec2 centre = shape.point(Vec3::Constant(1.0 / 3));
    for (int i = 0; i < 3; ++i) {
      const double h2 = (shape.vertex[i] - centre).squaredNorm();
      for (int g = 0; g < kGauss; ++g)
        if (counts(t, shape, table.on_spoke[i][g]))
          eta[t] += h2 * table.gauss.weights[g] *
                    (at(table.spoke[i][0][g]) - at(table.spoke[i][1][g])).squaredNorm();
    }
  });
  for (int e = 0; e < mesh.edge_count(); ++e) {
    poll_every<16384>(e);
    const auto& edge = mesh.edges()[e];
    if (edge.boundary()) continue;
    const auto [t, other] = edge.triangle;
    if (trim && (trim->side(t) == Trim::Side::Outside || trim->side(other) == Trim::Side::Outside))
      continue;
    const TriangleShape shape = mesh.shape(t);
    const int i = edge.local[0], k = edge.local[1];
    const double length = mesh.edge_length(e);
    double jump2 = 0;
    // The two triangles traverse the edge in opposite directions.
    for (int g = 0; g < kGauss; ++g)
      if (counts(t, shape, table.on_edge[i][g]))
        jump2 += table.gauss.weights[g] *
                 (edges[t][i][g] - edges[other][k][kGauss - 1 - g]).squaredNorm();
    const double half = 0.5 * length * length * jump2;
    eta[t] += half;
    eta[other] += half;
  }
  return eta;
}

namespace {

// The longest edge must be the same for all triangles, whatever the rounding: among edges of equal
// length, to 1e-9, the one with the lowest index.
int longest_edge(const ParametricMesh& mesh, int t) {
  const auto& edges = mesh.edges_of(t);
  double longest = 0;
  for (const int e : edges) longest = std::max(longest, mesh.edge_length(e));
  int best = -1;
  for (int i = 0; i < 3; ++i)
    if (mesh.edge_length(edges[i]) >= (1 - 1e-9) * longest && (best < 0 || edges[i] < edges[best]))
      best = i;
  return best;
}

// Bisects triangles at the midpoints of their edges (-1: none), the longest edge first.
std::vector<ParametricMesh::Triangle> halves_of(const ParametricMesh& mesh,
                                                const std::vector<int>& longest,
                                                const std::vector<int>& midpoint) {
  std::vector<ParametricMesh::Triangle> triangles;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto& v = mesh.triangles()[t];
    const int i = longest[t], j = (i + 1) % 3, k = (i + 2) % 3;
    const auto& e = mesh.edges_of(t);
    const int m = midpoint[e[i]];
    if (m < 0) {
      triangles.push_back(v);
      continue;
    }
    // (V_i, V_j, M) contains edge k, (V_i, M, V_k) edge j.
    if (const int n = midpoint[e[k]]; n >= 0) {
      triangles.push_back({v[i], n, m});
      triangles.push_back({n, v[j], m});
    } else {
      triangles.push_back({v[i], v[j], m});
    }
    if (const int n = midpoint[e[j]]; n >= 0) {
      triangles.push_back({v[i], m, n});
      triangles.push_back({n, m, v[k]});
    } else {
      triangles.push_back({v[i], m, v[k]});
    }
  }
  return triangles;
}

}  // namespace

Bisection bisected(const ParametricMesh& mesh, const std::vector<char>& marked) {
  if (isize(marked) != mesh.triangle_count())
    throw InputError("found " + std::to_string(marked.size()) + " refinement marks for " +
                     std::to_string(mesh.triangle_count()) + " triangles, expected one for each");
  std::vector<int> longest(mesh.triangle_count());
  std::vector<char> split(mesh.edge_count(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<8192>(t);
    longest[t] = longest_edge(mesh, t);
  }

  // A triangle with a bisected edge also bisects its longest edge.
  std::vector<int> pending;
  const auto halve = [&](int e) {
    if (split[e]) return;
    split[e] = 1;
    for (const int t : mesh.edges()[e].triangle)
      if (t >= 0) pending.push_back(t);
  };
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (marked[t]) halve(mesh.edges_of(t)[longest[t]]);
  while (!pending.empty()) {
    const int t = pending.back();
    pending.pop_back();
    halve(mesh.edges_of(t)[longest[t]]);
  }

  std::vector<Vec2> vertices = mesh.vertices();
  std::vector<int> midpoint(mesh.edge_count(), -1);
  for (int e = 0; e < mesh.edge_count(); ++e) {
    if (!split[e]) continue;
    const auto& edge = mesh.edges()[e];
    midpoint[e] = isize(vertices);
    const TriangleShape shape = mesh.shape(edge.triangle[0]);
    const int i = edge.local[0];
    vertices.push_back(mesh.wrapped(0.5 * (shape.vertex[(i + 1) % 3] + shape.vertex[(i + 2) % 3])));
  }
  return {{std::move(vertices), halves_of(mesh, longest, midpoint), mesh.period()},
          std::move(midpoint)};
}

Submesh extract_submesh(const ParametricMesh& mesh, const std::vector<int>& wanted) {
  std::vector<int> number(mesh.vertex_count(), -1);
  for (const int t : wanted)
    for (const int v : mesh.triangles()[t]) number[v] = 0;
  std::vector<Vec2> vertices;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (number[v] == 0) {
      number[v] = isize(vertices);
      vertices.push_back(mesh.vertices()[v]);
    }
  std::vector<ParametricMesh::Triangle> triangles;
  for (const int t : wanted) {
    auto triangle = mesh.triangles()[t];
    for (int& v : triangle) v = number[v];
    triangles.push_back(triangle);
  }
  return {{std::move(vertices), std::move(triangles), mesh.period()}, std::move(number)};
}

namespace {

// Entities that the new mesh shares with the old one: old index, or -1.
struct SharedEntities {
  std::vector<int> vertex, edge;
  std::vector<char> triangle;

  SharedEntities(const ParametricMesh& from, const ParametricMesh& to)
      : vertex(to.vertex_count(), -1), edge(to.edge_count(), -1), triangle(to.triangle_count(), 0) {
    std::vector<std::pair<std::pair<double, double>, int>> places;
    for (int v = 0; v < from.vertex_count(); ++v)
      places.push_back({{from.vertices()[v].x(), from.vertices()[v].y()}, v});
    throw_if_cancelled();
    std::sort(places.begin(), places.end());
    for (int v = 0; v < to.vertex_count(); ++v) {
      poll_every<8192>(v);
      const std::pair<double, double> place{to.vertices()[v].x(), to.vertices()[v].y()};
      const auto found = std::lower_bound(places.begin(), places.end(), std::pair{place, 0});
      if (found != places.end() && found->first == place) vertex[v] = found->second;
    }
    for (int e = 0; e < to.edge_count(); ++e) {
      poll_every<16384>(e);
      const int low = vertex[to.edges()[e].low], high = vertex[to.edges()[e].high];
      if (low >= 0 && high >= 0) edge[e] = from.edge_between(low, high);
    }
    for (int t = 0; t < to.triangle_count(); ++t) {
      poll_every<16384>(t);
      const int first = edge[to.edges_of(t)[0]], opposite = vertex[to.triangles()[t][0]];
      if (first < 0 || opposite < 0) continue;
      for (const int old : from.edges()[first].triangle)
        if (old >= 0)
          for (const int v : from.triangles()[old]) triangle[t] |= v == opposite;
    }
  }
};

// Distance of each new triangle from the old surface, the largest of six points.
std::vector<double> displacements(const Surface& from, const ParametricMesh& to,
                                  const SharedEntities& shared, const TriangleLocator& locator,
                                  const Points& new_dofs) {
  // The centroids of the three sub-triangles, and points between those and the edge midpoints.
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
      // The direction of the normal depends on the order of the vertex indices.
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
