#include "batten/mesh/features/stroke_cut.h"

#include <algorithm>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/mesh/features/minimum_cut.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

constexpr int kInside = 0, kOutside = 1, kBetween = 2;  // the first two are source and sink

void check_stroke(const TriangleMesh& mesh, const std::string& name,
                  const std::vector<int>& stroke) {
  if (stroke.empty()) throw InputError(name + " has no vertices, expected at least one");
  for (const int v : stroke) {
    if (v < 0 || v >= mesh.vertex_count())
      throw InputError(name + " names vertex " + std::to_string(v) + " of " +
                       std::to_string(mesh.vertex_count()));
    if (mesh.topology().component()[v] < 0)
      throw InputError(name + " names vertex " + std::to_string(v) + ", which has no triangles");
  }
}

/// kInside, kOutside or kBetween of each triangle.
std::vector<int> marked(const TriangleMesh& mesh, const std::vector<int>& inside,
                        const std::vector<int>& outside) {
  const MeshTopology& topology = mesh.topology();
  const auto& component = topology.component();
  for (const auto* stroke : {&inside, &outside})
    for (const int v : *stroke)
      if (component[v] != component[inside[0]])
        throw InputError("vertices " + std::to_string(inside[0]) + " and " + std::to_string(v) +
                         " of the strokes lie in parts of the mesh that are not connected, "
                         "expected one");
  std::vector<int> in = inside;
  std::sort(in.begin(), in.end());
  for (const int v : outside)
    if (std::binary_search(in.begin(), in.end(), v))
      throw InputError("the strokes touch at vertex " + std::to_string(v) +
                       ", expected triangles between them");
  std::vector<int> mark(topology.triangle_count(), kBetween);
  for (const int t : triangles_touching(topology, inside)) mark[t] = kInside;
  for (const int t : triangles_touching(topology, outside)) {
    if (mark[t] == kInside)
      throw InputError("the strokes touch at triangle " + std::to_string(t) +
                       ", expected triangles between them");
    mark[t] = kOutside;
  }
  return mark;
}

}  // namespace

FeatureCut stroke_cut(const TriangleMesh& mesh, const std::vector<int>& inside,
                      const std::vector<int>& outside, const CutOptions& options) {
  check(options);
  check_stroke(mesh, "the stroke inside", inside);
  check_stroke(mesh, "the stroke outside", outside);
  const MeshTopology& topology = mesh.topology();
  std::vector<int> node = marked(mesh, inside, outside);
  int nodes = 2;
  for (int& n : node)
    if (n == kBetween) n = nodes++;
  std::vector<DualEdge> graph_edges;
  std::vector<int> edges;
  const int part = topology.component()[inside[0]];
  for (int i = 0; i < isize(topology.edges()); ++i) {
    const auto& e = topology.edges()[i];
    if (e.left < 0 || e.right < 0 || topology.component()[e.low] != part) continue;
    graph_edges.push_back({node[e.left], node[e.right], 0});
    edges.push_back(i);
  }
  const std::vector<double> capacities = cut_capacities(mesh, edges, options);
  for (size_t i = 0; i < graph_edges.size(); ++i) graph_edges[i].capacity = capacities[i];

  const std::vector<char> near = source_side(nodes, kInside, kOutside, graph_edges);
  FeatureCut result{{}, {}, {}, 0};
  std::vector<char> feature(topology.triangle_count(), 0);
  for (int t = 0; t < topology.triangle_count(); ++t) {
    feature[t] = near[node[t]];
    if (feature[t]) result.triangles.push_back(t);
  }
  for (const DualEdge& graph_edge : graph_edges)
    if (near[graph_edge.a] != near[graph_edge.b]) result.cost += graph_edge.capacity;
  result.vertices = vertices_of_triangles(topology, result.triangles);
  result.chains = border_chains(topology, feature);
  return result;
}

}  // namespace batten
