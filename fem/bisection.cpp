#include "batten/fem/bisection.h"

#include "batten/core/errors.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

// Which edge is longest must be the same for all triangles and whatever the rounding: among edges
// that are equally long, to 1e-9, the one of lowest number.
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

// The triangles, cut at the midpoints of their edges (-1: none), the longest one first.
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
    // (V_i, V_j, M) carries edge k, (V_i, M, V_k) edge j.
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
    throw InputError(std::to_string(marked.size()) + " marks for " +
                     std::to_string(mesh.triangle_count()) + " triangles");
  std::vector<int> longest(mesh.triangle_count());
  std::vector<char> split(mesh.edge_count(), 0);
  for (int t = 0; t < mesh.triangle_count(); ++t) longest[t] = longest_edge(mesh, t);

  // A triangle with a halved edge halves its longest one too.
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

}  // namespace batten
