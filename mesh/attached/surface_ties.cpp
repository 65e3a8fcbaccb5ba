// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/attached/surface_ties.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/mesh/selection.h"

namespace batten {

Vec3 TiedNode::foot(const Points& points) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) sum += weights[k] * points.row(corners[k]).transpose();
  return sum;
}

/// Searches the closest points of ties.
class SurfaceTies::Search {
 public:
  Search(const TriangleMesh& mesh, std::span<const int> face_of_triangle)
      : mesh_(mesh),
        face_of_triangle_(face_of_triangle),
        tree_(mesh),
        part_(node_components(mesh.topology())) {}

  /// The closest point of the given faces; none given: of all faces of other parts.
  std::optional<TiedNode> in_faces(int node, const std::vector<char>& is_face) const {
    const int own = is_face.empty() ? part_[node] : -1;
    return closest(node, [&](int t) {
      if (own >= 0 && part_of_triangle(t) == own) return false;
      return is_face.empty() || is_face[face_of_triangle_[t]] != 0;
    });
  }
  std::optional<TiedNode> in_part(int node, int part) const {
    return closest(node, [&](int t) { return part_of_triangle(t) == part; });
  }
  double longest_edge(const TiedNode& tied) const {
    const auto& c = tied.corners;
    double longest = 0;
    for (const auto& [a, b] : {std::pair(c[0], c[1]), std::pair(c[1], c[2]), std::pair(c[2], c[0])})
      longest = std::max(longest, (mesh_.point(a) - mesh_.point(b)).norm());
    return longest;
  }
  std::vector<char> flags(const std::vector<int>& faces) const {
    std::vector<char> flags;
    if (faces.empty()) return flags;
    int last = *std::max_element(faces.begin(), faces.end());
    for (const int f : face_of_triangle_) last = std::max(last, f);
    flags.assign(static_cast<size_t>(last) + 1, 0);
    for (const int f : faces) flags[f] = 1;
    return flags;
  }
  /// Adds the nodes of the face of a triangle. The triangles of a face follow each other.
  void add_face(int triangle, std::vector<int>& nodes) const {
    const int face = face_of_triangle_[triangle];
    const auto add = [&](int t) {
      for (const int v : mesh_.triangles()[t]) nodes.push_back(mesh_.topology().node_of(v));
    };
    for (int t = triangle; t >= 0 && face_of_triangle_[t] == face; --t) add(t);
    for (int t = triangle + 1; t < mesh_.triangle_count() && face_of_triangle_[t] == face; ++t)
      add(t);
  }
  /// The part of the mesh to which a node belongs; -1: none.
  int part_of(int node) const { return part_[node]; }

 private:
  int part_of_triangle(int t) const {
    return part_[mesh_.topology().node_of(mesh_.triangles()[t][0])];
  }
  template <class Accepts>
  std::optional<TiedNode> closest(int node, const Accepts& accepts) const {
    const MeshTopology& topology = mesh_.topology();
    const auto found = tree_.nearest_among(mesh_.point(node), [&](int t) {
      const auto& corners = mesh_.triangles()[t];
      return accepts(t) && std::none_of(corners.begin(), corners.end(),
                                        [&](int v) { return topology.node_of(v) == node; });
    });
    if (!found) return {};
    TiedNode tied{
        node, mesh_.triangles()[found->triangle], found->weights, found->distance, found->triangle,
        -1};
    for (int& v : tied.corners) v = topology.node_of(v);
    return tied;
  }

  const TriangleMesh& mesh_;
  std::span<const int> face_of_triangle_;
  TriangleTree tree_;
  std::vector<int> part_;
};

SurfaceTies::SurfaceTies(std::span<const SurfaceTie> ties,
                         std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                         std::span<const int> face_of_triangle) {
  if (ties.empty()) return;
  const Search search(mesh, face_of_triangle);
  for (int t = 0; t < isize(ties); ++t) {
    names_.push_back(ties[t].name);
    attach(ties[t], t, search);
  }
  find_welds(elements, mesh, search);
  tie_through_solids(elements, search);
}

void SurfaceTies::attach(const SurfaceTie& tie, int index, const Search& search) {
  const bool weld = tie.kind == SurfaceTie::Kind::Weld;
  std::vector<std::vector<char>> sides;
  for (const auto& faces : tie.sides) sides.push_back(search.flags(faces));
  if (sides.empty()) sides.emplace_back();
  std::vector<int> body = tie.nodes;
  std::vector<std::pair<int, double>> far;  // part and distance of nodes
  std::set<int> tied_parts;
  for (const int node : tie.nodes)
    for (const auto& side : sides) {
      const auto found = search.in_faces(node, side);
      const double reach = !found ? 0 : tie.reach > 0 ? tie.reach : search.longest_edge(*found);
      if (!found || found->distance > reach) {
        far.emplace_back(search.part_of(node), found ? found->distance : 0);
        continue;
      }
      const int from = search.part_of(node), to = search.part_of(found->corners[0]);
      tied_parts.insert(from);
      if (weld) {
        search.add_face(found->triangle, body);
      } else if (from < 0 || from == to || !directions_.contains({to, from})) {
        directions_.insert({from, to});
        nodes_.push_back(*found);
        nodes_.back().tie = index;
      }
    }
  if (weld && body.size() > tie.nodes.size())
    welds_.push_back({tie.name, sorted_unique(std::move(body)), FormFeature::Kind::Free});
  // Contacts name whole parts, of which only the nodes nearby are tied.
  if (!weld) std::erase_if(far, [&](const auto& f) { return tied_parts.contains(f.first); });
  double farthest = 0;
  for (const auto& [part, distance] : far) farthest = std::max(farthest, distance);
  if (!far.empty())
    notes_.push_back(tie.name + ": " + std::to_string(far.size()) +
                     (far.size() == 1 ? " node" : " nodes") + " of " +
                     std::to_string(tie.nodes.size()) + " not attached, up to " +
                     format_number(farthest) +
                     " from the surface, which is more than the stated tolerance or the longest "
                     "edge of the closest face");
}

/// The index in nodes_ of each node of the mesh; -1: not tied.
std::vector<int> SurfaceTies::index_of_nodes(int count) const {
  std::vector<int> index(static_cast<size_t>(count), -1);
  for (int i = 0; i < isize(nodes_); ++i) index[nodes_[i].node] = i;
  return index;
}

void SurfaceTies::find_welds(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                             const Search& search) {
  constexpr double kStanding = 0.5;  // cosine of the largest angle from the normal
  const std::vector<int> index = index_of_nodes(mesh.vertex_count());
  std::set<int> welded;
  for (const NonShellElement& e : elements) {
    const bool bar = e.kind == NonShellElement::Kind::Beam || e.kind == NonShellElement::Kind::Bush;
    if (!bar || e.nodes.size() < 2) continue;
    const int a = index[e.nodes[0]], b = index[e.nodes[1]];
    if (a < 0 || b < 0 || nodes_[a].corners == nodes_[b].corners) continue;
    std::vector<int> body{e.nodes[0], e.nodes[1]};
    bool stands = true;
    const Vec3 axis = nodes_[b].foot(mesh.points()) - nodes_[a].foot(mesh.points());
    for (const int i : {a, b}) {
      const auto& c = nodes_[i].corners;
      const Vec3 normal =
          (mesh.point(c[1]) - mesh.point(c[0])).cross(mesh.point(c[2]) - mesh.point(c[0]));
      stands &= std::abs(axis.dot(normal)) >= kStanding * axis.norm() * normal.norm();
      search.add_face(nodes_[i].triangle, body);
    }
    if (!stands) continue;
    welded.insert({e.nodes[0], e.nodes[1]});
    welds_.push_back({names_[nodes_[a].tie] + ", " + e.name + " " + std::to_string(e.label),
                      sorted_unique(std::move(body)), FormFeature::Kind::Free});
  }
  std::erase_if(nodes_, [&](const TiedNode& tied) { return welded.contains(tied.node); });
}

void SurfaceTies::tie_through_solids(std::span<const NonShellElement> elements,
                                     const Search& search) {
  std::map<int, int> index;
  for (int i = 0; i < isize(nodes_); ++i) index[nodes_[i].node] = i;
  // The corners of the second part below the adhesive, for each pair of parts, and their tie.
  std::map<std::pair<int, int>, std::map<int, int>> corners;
  for (const NonShellElement& e : elements) {
    if (e.kind != NonShellElement::Kind::Solid) continue;
    std::map<int, std::vector<int>> by_part;
    for (const int v : e.nodes)
      if (const auto tied = index.find(v); tied != index.end())
        by_part[search.part_of(nodes_[tied->second].corners[0])].push_back(tied->second);
    for (auto second = by_part.begin(); second != by_part.end(); ++second)
      if (second != by_part.begin())
        for (const int i : second->second)
          for (const int v : nodes_[i].corners)
            corners[{by_part.begin()->first, second->first}].emplace(v, nodes_[i].tie);
  }
  for (const auto& [parts, members] : corners) {
    if (directions_.contains({parts.first, parts.second}) ||
        directions_.contains({parts.second, parts.first}))
      continue;
    for (const auto& [node, tie] : members)
      if (const auto found = search.in_part(node, parts.first)) {
        nodes_.push_back(*found);
        nodes_.back().tie = tie;
      }
  }
}

std::vector<LinearConstraint> SurfaceTies::constraints(const TriangleMesh& mesh,
                                                       const Points& points,
                                                       DeformProblem::Weighting weighting) const {
  constexpr double kStiffness = 1000;  // relative to the curvature equations
  std::vector<LinearConstraint> rows;
  for (const TiedNode& tied : nodes_) {
    if (mesh.topology().neighbours(tied.node).empty()) continue;
    LinearConstraint row;
    row.name = names_[tied.tie] + ", vertex " + std::to_string(tied.node + 1);
    row.combination.entries.push_back({tied.node, 1});
    int nearest = 0;
    for (int k = 0; k < 3; ++k) {
      row.combination.entries.push_back({tied.corners[k], -tied.weights[k]});
      if (tied.weights[k] > tied.weights[nearest]) nearest = k;
    }
    row.target = points.row(tied.node).transpose() - tied.foot(points);
    row.rotates_with = tied.corners[nearest];
    const Vec3 a = mesh.point(tied.corners[0]), b = mesh.point(tied.corners[1]),
               c = mesh.point(tied.corners[2]);
    const double area = (b - a).cross(c - a).norm() / 2;
    row.weight = kStiffness / (weighting == DeformProblem::Weighting::Area ? area : area * area);
    row.connects = true;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace batten
