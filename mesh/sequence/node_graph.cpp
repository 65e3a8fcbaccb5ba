#include "batten/mesh/sequence/node_graph.h"

#include <algorithm>

namespace batten {

NodeGraph node_graph(const MeshTopology& topology, const std::vector<double>& weights) {
  NodeGraph graph;
  graph.nodes = topology.node_count();
  for (size_t e = 0; e < topology.edges().size(); ++e) {
    const auto& edge = topology.edges()[e];
    const int a = topology.node_of(edge.low), b = topology.node_of(edge.high);
    graph.edges.push_back({std::min(a, b), std::max(a, b), weights.empty() ? 1.0 : weights[e]});
  }
  std::sort(graph.edges.begin(), graph.edges.end(),
            [](const auto& e, const auto& f) { return std::pair(e.a, e.b) < std::pair(f.a, f.b); });
  size_t kept = 0;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const auto edge = graph.edges[e];
    if (kept > 0 && graph.edges[kept - 1].a == edge.a && graph.edges[kept - 1].b == edge.b) {
      if (!weights.empty()) graph.edges[kept - 1].weight += edge.weight;
    } else {
      graph.edges[kept++] = edge;
    }
  }
  graph.edges.resize(kept);
  graph.start.assign(graph.nodes + 1, 0);
  for (const auto& e : graph.edges) ++graph.start[e.a + 1], ++graph.start[e.b + 1];
  for (int i = 0; i < graph.nodes; ++i) graph.start[i + 1] += graph.start[i];
  graph.neighbour.resize(graph.start.back());
  graph.weight.resize(graph.start.back());
  std::vector<int> next(graph.start.begin(), graph.start.end() - 1);
  const auto add = [&](int from, int to, double w) {
    graph.neighbour[next[from]] = to;
    graph.weight[next[from]++] = w;
  };
  // Sorted by (a, b): lower neighbours come first when they are entered first.
  for (const auto& e : graph.edges) add(e.b, e.a, e.weight);
  for (const auto& e : graph.edges) add(e.a, e.b, e.weight);
  return graph;
}

std::vector<Triplet> laplacian_entries(const NodeGraph& graph) {
  std::vector<Triplet> entries;
  entries.reserve(3 * graph.edges.size());
  for (const auto& e : graph.edges) {
    entries.emplace_back(e.a, e.a, e.weight);
    entries.emplace_back(e.b, e.b, e.weight);
    entries.emplace_back(e.b, e.a, -e.weight);
  }
  return entries;
}

}  // namespace batten
