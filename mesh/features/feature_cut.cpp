#include "batten/mesh/features/feature_cut.h"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <cmath>
#include <cstdint>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

// An undirected edge of the dual graph.
struct Arc {
  int a, b;
  double capacity;
};

// The nodes on the source's side of the minimum cut, as few as possible: those that residual
// capacity reaches from the source.
std::vector<char> source_side(int nodes, int source, int sink, const std::vector<Arc>& arcs) {
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
  for (const Arc& arc : arcs) sum += arc.capacity;
  const double unit = sum > 0 ? 0x1p52 / sum : 0;
  Graph graph(nodes);
  for (const Arc& arc : arcs) {
    const auto there = add_edge(arc.a, arc.b, graph).first;
    const auto back = add_edge(arc.b, arc.a, graph).first;
    graph[there].capacity = graph[back].capacity = std::llround(arc.capacity * unit);
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

constexpr int kBand = 0;  // parts are 1, 2, …; -1 in other parts of the mesh

class FeatureCutter {
 public:
  FeatureCutter(const TriangleMesh& mesh, const std::vector<int>& band, const CutOptions& options)
      : mesh_(mesh), topology_(mesh.topology()), options_(options) {
    for (const double eta : {options.concave, options.convex})
      if (!(eta >= 0) || !std::isfinite(eta))
        throw InputError("weight " + number(eta) + " of a bend, expected 0 or more");
    mark_band(band);
    find_parts();
    feature_part_ = options.feature_vertex < 0 ? smaller_part() : part_with(options.feature_vertex);
  }

  FeatureCut cut() {
    const std::vector<Arc> arcs = dual_arcs();
    // Nodes: the source, the sink, then the band.
    const std::vector<char> near = source_side(2 + count_of(band_), 0, 1, arcs);
    FeatureCut result{{}, {}, {}, 0};
    std::vector<char> inside(topology_.triangle_count(), 0);
    for (int t = 0; t < topology_.triangle_count(); ++t) {
      inside[t] = part_[t] >= 0 && near[node_of(t)];
      if (inside[t]) result.triangles.push_back(t);
    }
    for (const Arc& arc : arcs)
      if (near[arc.a] != near[arc.b]) result.cost += arc.capacity;
    result.vertices = vertices_of_triangles(topology_, result.triangles);
    result.chains = border_chains(topology_, inside);
    return result;
  }

 private:
  void mark_band(const std::vector<int>& band) {
    if (band.empty()) throw InputError("the band has no triangles");
    band_number_.assign(topology_.triangle_count(), -1);
    part_.assign(topology_.triangle_count(), -1);
    for (const int t : band) {
      if (t < 0 || t >= topology_.triangle_count())
        throw InputError("triangle " + std::to_string(t) +
                         " of the band does not exist: there are " +
                         std::to_string(topology_.triangle_count()));
      part_[t] = kBand;
    }
    for (int t = 0; t < topology_.triangle_count(); ++t)
      if (part_[t] == kBand) {
        band_number_[t] = count_of(band_);
        band_.push_back(t);
      }
    component_ = component_of(band_.front());
    for (const int t : band_)
      if (component_of(t) != component_)
        throw InputError(
            "the band lies in several parts of the mesh that are not connected, "
            "expected one: triangles " +
            std::to_string(band_.front()) + " and " + std::to_string(t));
  }

  int component_of(int triangle) const {
    return topology_.component()[topology_.triangles()[triangle][0]];
  }

  // What is left of the band's component when the band is taken out.
  void find_parts() {
    std::vector<int> sizes, stack;
    for (int seed = 0; seed < topology_.triangle_count(); ++seed) {
      if (part_[seed] >= 0 || component_of(seed) != component_) continue;
      const int part = count_of(sizes) + 1;
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
    if (sizes.empty()) throw InputError("the band covers everything, expected 2 parts beside it");
    std::string what = "the band leaves " + std::to_string(sizes.size());
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
      throw InputError(name + " of the feature does not exist: there are " +
                       std::to_string(topology_.vertex_count()));
    bool found[3] = {};
    for (const int t : topology_.triangles_of(vertex))
      if (part_[t] > 0) found[part_[t]] = true;
    if (found[1] == found[2])
      throw InputError(
          name + (found[1] ? " lies on both sides of the band" : " lies on no side of the band") +
          ", expected on the feature's side");
    return found[1] ? 1 : 2;
  }

  int node_of(int triangle) const {
    const int part = part_[triangle];
    return part == kBand ? 2 + band_number_[triangle] : part == feature_part_ ? 0 : 1;
  }

  double distance(const MeshTopology::Edge& e) const {
    const Vec3 left = mesh_.area_vector(e.left), right = mesh_.area_vector(e.right);
    const double norms = left.norm() * right.norm();
    if (!(norms > 0)) return 0;
    // The tip of the right triangle above the left one: the surface bends towards its normal.
    const auto& corners = topology_.triangles()[e.right];
    const int tip = *std::find_if(corners.begin(), corners.end(),
                                  [&](int v) { return v != e.low && v != e.high; });
    const bool concave = left.dot(mesh_.point(tip) - mesh_.point(e.low)) > 0;
    return (concave ? options_.concave : options_.convex) * (1 - left.dot(right) / norms);
  }

  std::vector<Arc> dual_arcs() const {
    std::vector<Arc> arcs;
    std::vector<double> d;
    double sum = 0;
    for (const auto& e : topology_.edges()) {
      if (e.left < 0 || e.right < 0 || (part_[e.left] != kBand && part_[e.right] != kBand))
        continue;
      arcs.push_back(
          {node_of(e.left), node_of(e.right), (mesh_.point(e.high) - mesh_.point(e.low)).norm()});
      d.push_back(distance(e));
      sum += d.back();
    }
    constexpr double tenth_of_a_degree = 1.523e-6;  // 1 - cos
    const double mean = std::max(sum / static_cast<double>(d.size()), tenth_of_a_degree);
    for (size_t i = 0; i < arcs.size(); ++i) arcs[i].capacity /= 1 + d[i] / mean;
    return arcs;
  }

  const TriangleMesh& mesh_;
  const MeshTopology& topology_;
  const CutOptions& options_;
  std::vector<int> band_, band_number_;  // its triangles; of a triangle its place among them
  std::vector<int> part_;                // of triangles
  int component_ = 0, feature_part_ = 0;
};

}  // namespace

FeatureCut cut_feature(const TriangleMesh& mesh, const std::vector<int>& band,
                       const CutOptions& options) {
  return FeatureCutter(mesh, band, options).cut();
}

}  // namespace batten
