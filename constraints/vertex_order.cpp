#include "batten/constraints/vertex_order.h"

#include <algorithm>

#include "batten/core/elimination_order.h"
#include "batten/core/errors.h"
#include "batten/core/index.h"

namespace batten {
namespace {

// Vertices with free unknowns of their own are the nodes.
struct Nodes {
  std::vector<int> of_vertex;   // -1: none of its dofs is free
  std::vector<int> of_unknown;  // -1: an edge's
  int count = 0;
};

Nodes nodes_of(const std::vector<int>& free_dofs, const DofVertices& vertices) {
  Nodes nodes;
  for (const auto& ends : vertices)
    nodes.of_vertex.resize(
        std::max(nodes.of_vertex.size(), static_cast<size_t>(std::max(ends[0], ends[1])) + 1), -1);
  for (const int dof : free_dofs) {
    const auto [a, b] = vertices[dof];
    int& node = nodes.of_vertex[a];
    if (a == b && node < 0) node = nodes.count++;
    nodes.of_unknown.push_back(a == b ? node : -1);
  }
  return nodes;
}

// Which nodes `reduced` couples: a lower triangle. The unknowns of a node follow one another.
SparseMatrix graph_of(const SparseMatrix& reduced, const Nodes& nodes) {
  std::vector<int> last(static_cast<size_t>(nodes.count), -1), starts, rows;
  for (int j = 0; j < reduced.cols(); ++j) {
    const int own = nodes.of_unknown[j];
    if (own < 0) continue;
    if (own == count_of(starts)) {
      starts.push_back(count_of(rows));
      rows.push_back(own);
      last[own] = own;
    }
    for (SparseMatrix::InnerIterator it(reduced, j); it; ++it) {
      const int other = nodes.of_unknown[it.row()];
      if (other < 0 || last[other] == own) continue;
      last[other] = own;
      rows.push_back(other);
    }
  }
  starts.push_back(count_of(rows));
  SparseMatrix graph(nodes.count, nodes.count);
  graph.resizeNonZeros(static_cast<long>(rows.size()));
  std::copy(starts.begin(), starts.end(), graph.outerIndexPtr());
  for (size_t s = 0; s + 1 < starts.size(); ++s)
    std::sort(rows.begin() + starts[s], rows.begin() + starts[s + 1]);
  std::copy(rows.begin(), rows.end(), graph.innerIndexPtr());
  std::fill_n(graph.valuePtr(), rows.size(), 1.0);
  return graph;
}

}  // namespace

std::vector<int> vertex_order(const AffineReduction& reduction, const SparseMatrix& reduced,
                              const DofVertices& vertices, Expected expected) {
  const std::vector<int>& free_dofs = reduction.free_dofs();
  if (reduction.coupled() || static_cast<long>(vertices.size()) != reduction.D().rows())
    throw InputError("vertices of " + std::to_string(vertices.size()) + " dofs for " +
                     std::to_string(reduction.D().rows()));
  const Nodes nodes = nodes_of(free_dofs, vertices);
  const std::vector<int> order = elimination_order(graph_of(reduced, nodes), expected);
  std::vector<int> place(order.size());
  for (size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<int>(i) + 1;
  // An edge between vertices that have nothing free comes first of all, at place 0.
  const auto place_of = [&](int dof) {
    const auto [a, b] = vertices[dof];
    const int node = nodes.of_vertex[a], other = nodes.of_vertex[b];
    if (node < 0) return other < 0 ? 0 : place[other];
    if (other < 0) return place[node];
    return std::min(place[node], place[other]);
  };
  std::vector<int> starts(order.size() + 2, 0), unknowns(free_dofs.size());
  for (const int dof : free_dofs) ++starts[static_cast<size_t>(place_of(dof)) + 1];
  for (size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  for (size_t f = 0; f < free_dofs.size(); ++f)
    unknowns[starts[place_of(free_dofs[f])]++] = static_cast<int>(f);
  return unknowns;
}

}  // namespace batten
