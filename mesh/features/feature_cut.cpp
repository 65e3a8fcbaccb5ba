// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/features/feature_cut.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <cmath>
#include <cstdint>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

// An undirected edge of the dual graph; a and b are its nodes.
struct DualEdge {
  int a, b;
  double capacity;
};

// Nodes on the source side of the minimum cut: one flag per node. The smallest such set is taken,
// the nodes reachable from the source through residual capacity.
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

// Cost of each of the given edges, which must have two triangles.
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

void check_weights(const CutOptions& options) {
  for (const double eta : {options.concave, options.convex})
    if (!(eta >= 0) || !std::isfinite(eta))
      throw InputError("found the bend weight " + format_number(eta) + ", expected 0 or more");
}

constexpr int kBandPart = 0;  // part_ of triangles in the band; the parts beside it are 1, 2, …;
                              // -1: other components of the mesh

class FeatureCutter {
 public:
  FeatureCutter(const TriangleMesh& mesh, const std::vector<int>& band, const CutOptions& options)
      : mesh_(mesh), topology_(mesh.topology()), options_(options) {
    check_weights(options);
    mark_band(band);
    find_parts();
    feature_part_ = options.feature_vertex < 0 ? smaller_part() : part_with(options.feature_vertex);
  }

  FeatureCut cut() {
    const std::vector<DualEdge> graph_edges = dual_edges();
    // Graph nodes: the source (feature side), the sink (panel side), then the triangles of the
    // band.
    const std::vector<char> near = source_side(2 + isize(band_), 0, 1, graph_edges);
    FeatureCut result{{}, {}, {}, 0};
    std::vector<char> inside(topology_.triangle_count(), 0);
    for (int t = 0; t < topology_.triangle_count(); ++t) {
      inside[t] = part_[t] >= 0 && near[graph_node_of(t)];
      if (inside[t]) result.triangles.push_back(t);
    }
    for (const DualEdge& graph_edge : graph_edges)
      if (near[graph_edge.a] != near[graph_edge.b]) result.cost += graph_edge.capacity;
    result.vertices = vertices_of_triangles(topology_, result.triangles);
    result.chains = border_chains(topology_, inside);
    return result;
  }

 private:
  void mark_band(const std::vector<int>& band) {
    if (band.empty()) throw InputError("the band has no triangles, expected one or more");
    band_number_.assign(topology_.triangle_count(), -1);
    part_.assign(topology_.triangle_count(), -1);
    for (const int t : band) {
      if (t < 0 || t >= topology_.triangle_count())
        throw InputError("found triangle " + std::to_string(t) + " of the band, expected 0 to " +
                         std::to_string(topology_.triangle_count() - 1));
      part_[t] = kBandPart;
    }
    for (int t = 0; t < topology_.triangle_count(); ++t)
      if (part_[t] == kBandPart) {
        band_number_[t] = isize(band_);
        band_.push_back(t);
      }
    component_ = component_of(band_.front());
    for (const int t : band_)
      if (component_of(t) != component_)
        throw InputError(
            "triangles " + std::to_string(band_.front()) + " and " + std::to_string(t) +
            " of the band lie in parts of the mesh that are not connected, expected one part");
  }

  int component_of(int triangle) const {
    return topology_.component()[topology_.triangles()[triangle][0]];
  }

  // Finds the edge-connected parts of the band's component without the band. Throws unless there
  // are two.
  void find_parts() {
    std::vector<int> sizes, stack;
    for (int seed = 0; seed < topology_.triangle_count(); ++seed) {
      if (part_[seed] >= 0 || component_of(seed) != component_) continue;
      const int part = isize(sizes) + 1;
      sizes.push_back(0);
      part_[seed] = part;
      stack.push_back(seed);
      while (!stack.empty()) {
        const int t = stack.back();
        stack.pop_back();
        ++sizes.back();
        for (int c = 0; c < 3; ++c) {
          const int other = topology_.across(t, c);
          if (other < 0 || part_[other] >= 0) continue;
          part_[other] = part;
          stack.push_back(other);
        }
      }
    }
    if (sizes.size() == 2) return;
    if (sizes.empty())
      throw InputError(
          "the band covers the whole part of the mesh, expected it to separate 2 parts");
    std::string what = "the band separates " + std::to_string(sizes.size());
    what += sizes.size() == 1 ? " part" : " parts";
    constexpr size_t named = 8;
    for (size_t i = 0; i < std::min(sizes.size(), named); ++i) {
      what += i == 0 ? " of " : i + 1 == sizes.size() ? " and " : ", ";
      what += std::to_string(sizes[i]);
    }
    if (sizes.size() > named) what += ", …";
    throw InputError(what + " triangles, expected 2");
  }

  int smaller_part() const {
    double area[3] = {};
    for (int t = 0; t < topology_.triangle_count(); ++t)
      if (part_[t] > 0) area[part_[t]] += mesh_.area_vector(t).norm();
    return area[1] <= area[2] ? 1 : 2;
  }

  int part_with(int vertex) const {
    const std::string name = "vertex " + std::to_string(vertex);
    if (vertex >= topology_.vertex_count())
      throw InputError("found " + name + " of the feature, expected 0 to " +
                       std::to_string(topology_.vertex_count() - 1));
    bool found[3] = {};
    for (const int t : topology_.triangles_of(vertex))
      if (part_[t] > 0) found[part_[t]] = true;
    if (found[1] == found[2])
      throw InputError(
          name +
          (found[1] ? " lies on both sides of the band" : " lies on neither side of the band") +
          ", expected on the feature's side");
    return found[1] ? 1 : 2;
  }

  int graph_node_of(int triangle) const {
    const int part = part_[triangle];
    return part == kBandPart ? 2 + band_number_[triangle] : part == feature_part_ ? 0 : 1;
  }

  std::vector<DualEdge> dual_edges() const {
    std::vector<DualEdge> graph_edges;
    std::vector<int> edges;
    for (int i = 0; i < isize(topology_.edges()); ++i) {
      const auto& e = topology_.edges()[i];
      if (e.left < 0 || e.right < 0 || (part_[e.left] != kBandPart && part_[e.right] != kBandPart))
        continue;
      graph_edges.push_back({graph_node_of(e.left), graph_node_of(e.right), 0});
      edges.push_back(i);
    }
    const std::vector<double> capacities = cut_capacities(mesh_, edges, options_);
    for (size_t i = 0; i < graph_edges.size(); ++i) graph_edges[i].capacity = capacities[i];
    return graph_edges;
  }

  const TriangleMesh& mesh_;
  const MeshTopology& topology_;
  const CutOptions& options_;
  std::vector<int> band_, band_number_;  // triangles of the band; per triangle its index in band_,
                                         // or -1
  std::vector<int> part_;                // per triangle
  int component_ = 0, feature_part_ = 0;
};

}  // namespace

FeatureCut cut_feature(const TriangleMesh& mesh, const std::vector<int>& band,
                       const CutOptions& options) {
  return FeatureCutter(mesh, band, options).cut();
}

namespace {

constexpr int kInside = 0, kOutside = 1, kBetween = 2;  // graph nodes of the source and the sink;
                                                        // mark of the triangles between them

void check_stroke(const TriangleMesh& mesh, const std::string& name,
                  const std::vector<int>& stroke) {
  if (stroke.empty()) throw InputError(name + " has no vertices, expected at least one");
  for (const int v : stroke) {
    if (v < 0 || v >= mesh.vertex_count())
      throw InputError(name + ": found vertex " + std::to_string(v) + ", expected 0 to " +
                       std::to_string(mesh.vertex_count() - 1));
    if (mesh.topology().component()[v] < 0)
      throw InputError(name + ": vertex " + std::to_string(v) + " belongs to no triangle");
  }
}

/// kInside, kOutside or kBetween for each triangle.
std::vector<int> marked(const TriangleMesh& mesh, const std::vector<int>& inside,
                        const std::vector<int>& outside) {
  const MeshTopology& topology = mesh.topology();
  const auto& component = topology.component();
  for (const auto* stroke : {&inside, &outside})
    for (const int v : *stroke)
      if (component[v] != component[inside[0]])
        throw InputError("vertices " + std::to_string(inside[0]) + " and " + std::to_string(v) +
                         " of the strokes lie in parts of the mesh that are not connected, "
                         "expected one part");
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
  check_weights(options);
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

namespace {

// A side of a triangle: the edge opposite to `corner`.
struct ChainSide {
  int triangle, corner;
};

class BorderWalk {
 public:
  BorderWalk(const MeshTopology& topology, const std::vector<char>& inside)
      : topology_(topology), inside_(inside), taken_(3 * inside.size(), 0) {}

  std::vector<BorderChain> chains() {
    std::vector<ChainSide> sides;
    for (int t = 0; t < topology_.triangle_count(); ++t)
      for (int c = 0; c < 3; ++c)
        if (on_border({t, c})) sides.push_back({t, c});
    std::vector<BorderChain> result;
    for (const ChainSide& side : sides)  // open chains from their first side
      if (!taken(side) && previous(side).triangle < 0) result.push_back(walk(side));
    for (const ChainSide& side : sides)
      if (!taken(side)) result.push_back(walk(side));
    for (BorderChain& chain : result)
      if (chain.closed) {
        auto& v = chain.vertices;
        std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
      }
    std::sort(result.begin(), result.end(),
              [](const BorderChain& a, const BorderChain& b) { return a.vertices < b.vertices; });
    return result;
  }

 private:
  char& taken(const ChainSide& s) { return taken_[3 * s.triangle + s.corner]; }

  // Sides belong to triangles inside and are traversed in the direction of the triangles outside.
  bool on_border(const ChainSide& s) const {
    if (!inside_[s.triangle]) return false;
    const int other = topology_.across(s.triangle, s.corner);
    return other >= 0 && !inside_[other];
  }

  int first(const ChainSide& s) const {
    return topology_.triangles()[s.triangle][(s.corner + 2) % 3];
  }
  int last(const ChainSide& s) const {
    return topology_.triangles()[s.triangle][(s.corner + 1) % 3];
  }

  int corner_of(int triangle, int vertex) const {
    const auto& t = topology_.triangles()[triangle];
    return static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin());
  }

  // Rotates around an end of a side, through triangles inside, up to the next border side. The
  // result has triangle -1 if the mesh ends before that. `step`: offset from the corner at the
  // vertex to the corner opposite to the exit side. 1 rotates around the last vertex, 2 around the
  // first.
  ChainSide pivot(const ChainSide& s, int vertex, int step) const {
    for (int t = s.triangle;;) {
      const ChainSide exit{t, (corner_of(t, vertex) + step) % 3};
      const int other = topology_.across(exit.triangle, exit.corner);
      if (other < 0) return {-1, -1};
      if (!inside_[other]) return exit;
      t = other;
    }
  }
  ChainSide next(const ChainSide& s) const { return pivot(s, last(s), 1); }
  ChainSide previous(const ChainSide& s) const { return pivot(s, first(s), 2); }

  BorderChain walk(ChainSide side) {
    BorderChain chain;
    for (;;) {
      taken(side) = 1;
      chain.vertices.push_back(first(side));
      const ChainSide following = next(side);
      if (following.triangle < 0) {
        chain.vertices.push_back(last(side));
        chain.closed = false;
        return chain;
      }
      if (taken(following)) return chain;
      side = following;
    }
  }

  const MeshTopology& topology_;
  const std::vector<char>& inside_;
  std::vector<char> taken_;
};

}  // namespace

std::vector<BorderChain> border_chains(const MeshTopology& topology,
                                       const std::vector<char>& inside) {
  return BorderWalk(topology, inside).chains();
}

}  // namespace batten
