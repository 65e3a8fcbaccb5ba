#include "batten/mesh/features/minimum_cut.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <cmath>
#include <cstdint>

#include "batten/core/errors.h"

namespace batten {
namespace {

// d = η (1 - cos a) of an edge, with the η of its kind.
double bending(const TriangleMesh& mesh, const MeshTopology::Edge& e, const CutOptions& options) {
  const Vec3 left = mesh.area_vector(e.left), right = mesh.area_vector(e.right);
  const double norms = left.norm() * right.norm();
  if (!(norms > 0)) return 0;
  // Concave if the opposite vertex of the right triangle lies above the plane of the left one.
  const auto& corners = mesh.topology().triangles()[e.right];
  const int opposite_vertex = *std::find_if(corners.begin(), corners.end(),
                                            [&](int v) { return v != e.low && v != e.high; });
  const bool concave = left.dot(mesh.point(opposite_vertex) - mesh.point(e.low)) > 0;
  return (concave ? options.concave : options.convex) * (1 - left.dot(right) / norms);
}

}  // namespace

std::vector<char> source_side(int nodes, int source, int sink,
                              const std::vector<DualEdge>& graph_edges) {
  using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
  using Amount = std::int64_t;
  struct Node {
    boost::default_color_type color = boost::white_color;
    Amount distance = 0;
    Traits::edge_descriptor predecessor;
  };
  struct Edge {
    Amount capacity = 0, residual = 0;
    Traits::edge_descriptor reverse;
  };
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, Node, Edge>;

  double sum = 0;
  for (const DualEdge& graph_edge : graph_edges) sum += graph_edge.capacity;
  const double unit = sum > 0 ? 0x1p52 / sum : 0;
  Graph graph(nodes);
  for (const DualEdge& graph_edge : graph_edges) {
    const auto there = add_edge(graph_edge.a, graph_edge.b, graph).first;
    const auto back = add_edge(graph_edge.b, graph_edge.a, graph).first;
    graph[there].capacity = graph[back].capacity = std::llround(graph_edge.capacity * unit);
    graph[there].reverse = back;
    graph[back].reverse = there;
  }
  boykov_kolmogorov_max_flow(graph, get(&Edge::capacity, graph), get(&Edge::residual, graph),
                             get(&Edge::reverse, graph), get(&Node::predecessor, graph),
                             get(&Node::color, graph), get(&Node::distance, graph),
                             get(boost::vertex_index, graph), source, sink);
  std::vector<char> reached(nodes, 0);
  std::vector<int> stack = {source};
  reached[source] = 1;
  while (!stack.empty()) {
    const int node = stack.back();
    stack.pop_back();
    for (auto [edge, end] = out_edges(node, graph); edge != end; ++edge) {
      const int other = static_cast<int>(target(*edge, graph));
      if (graph[*edge].residual > 0 && !reached[other]) {
        reached[other] = 1;
        stack.push_back(other);
      }
    }
  }
  return reached;
}

std::vector<double> cut_capacities(const TriangleMesh& mesh, const std::vector<int>& edges,
                                   const CutOptions& options) {
  std::vector<double> bends, capacities;
  double sum = 0;
  for (const int i : edges) {
    const auto& e = mesh.topology().edges()[i];
    capacities.push_back((mesh.point(e.high) - mesh.point(e.low)).norm());
    bends.push_back(bending(mesh, e, options));
    sum += bends.back();
  }
  constexpr double tenth_of_a_degree = 1.523e-6;  // 1 - cos
  const double mean = std::max(sum / static_cast<double>(edges.size()), tenth_of_a_degree);
  for (size_t i = 0; i < edges.size(); ++i) capacities[i] /= 1 + bends[i] / mean;
  return capacities;
}

void check(const CutOptions& options) {
  for (const double eta : {options.concave, options.convex})
    if (!(eta >= 0) || !std::isfinite(eta))
      throw InputError("found the bend weight " + format_number(eta) + ", expected 0 or more");
}

}  // namespace batten
