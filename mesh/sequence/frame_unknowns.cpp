// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/frame_unknowns.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/mesh/regions/local_global_iteration.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

/// Merged features that share nodes, and the constraints on any of these nodes.
struct FeatureGroup {
  std::vector<int> nodes;
  std::string name;
  int handle = -1;
  bool is_fixed = false, may_rotate = true;
};

std::vector<FeatureGroup> group_features(const NodeGraph& graph,
                                         const FrameConstraints& constraints,
                                         const std::vector<int>& handle_of,
                                         const std::vector<char>& fixed) {
  const size_t count = constraints.features.size();
  DisjointSets groups(count);
  std::vector<int> first(graph.nodes, -1);
  for (size_t f = 0; f < count; ++f)
    for (const int v : constraints.features[f].vertices) {
      if (first[v] < 0) first[v] = static_cast<int>(f);
      groups.unite(first[v], static_cast<int>(f));
    }
  std::vector<FeatureGroup> all(count);
  for (size_t f = 0; f < count; ++f) {
    const auto& feature = constraints.features[f];
    FeatureGroup& group = all[groups.find(static_cast<int>(f))];
    group.name += (group.name.empty() ? "" : ", ") + feature.name;
    group.may_rotate = group.may_rotate && feature.kind != FormFeature::Kind::TranslationOnly;
    for (const int v : feature.vertices) {
      group.nodes.push_back(v);
      group.is_fixed = group.is_fixed || fixed[v];
      if (handle_of[v] >= 0 && (group.handle < 0 || handle_of[v] < group.handle))
        group.handle = handle_of[v];
    }
  }
  std::erase_if(all, [](const auto& group) { return group.nodes.empty(); });
  for (auto& group : all) group.nodes = sorted_unique(std::move(group.nodes));
  return all;
}

}  // namespace

FrameUnknowns frame_unknowns(const NodeGraph& graph, const FrameConstraints& constraints) {
  FrameUnknowns u;
  const bool soft = constraints.penalty_weight.has_value();
  std::vector<int> handle_of(graph.nodes, -1);
  std::vector<char> fixed(graph.nodes, 0);
  for (const int v : constraints.fixed) fixed[v] = 1;
  for (int h = 0; h < isize(constraints.handles); ++h)
    for (const int v : sorted_unique(constraints.handles[h].vertices)) {
      if (soft) u.penalized_nodes.push_back({v, h});
      if (handle_of[v] >= 0 && handle_of[v] != h)
        u.shared.push_back({v, handle_of[v], h});
      else
        handle_of[v] = h;
    }
  if (soft) handle_of.assign(graph.nodes, -1);

  u.part_of_node.assign(graph.nodes, -1);
  const auto groups = group_features(graph, constraints, handle_of, fixed);
  for (const auto& group : groups) {
    if (group.is_fixed)
      for (const int v : group.nodes) fixed[v] = 1;
    else if (group.handle >= 0)
      for (const int v : group.nodes)
        if (handle_of[v] < 0) handle_of[v] = group.handle;
  }
  // Nodes of a handle that are also fixed stay; the handle does not affect them.
  const auto add_part = [&](FrameUnknowns::RigidPart part) {
    for (const int v : part.nodes) u.part_of_node[v] = isize(u.parts);
    u.parts.push_back(std::move(part));
  };
  if (!soft) {
    std::vector<std::vector<int>> nodes(constraints.handles.size());
    for (int v = 0; v < graph.nodes; ++v)
      if (handle_of[v] >= 0 && !fixed[v]) nodes[handle_of[v]].push_back(v);
    for (int h = 0; h < isize(constraints.handles); ++h)
      if (!nodes[h].empty()) add_part({constraints.handles[h].name, nodes[h], h, -1, true, {}});
  }
  std::vector<char> is_constrained(graph.nodes, 0);
  for (int v = 0; v < graph.nodes; ++v) is_constrained[v] = fixed[v] || u.part_of_node[v] >= 0;
  for (const auto& group : groups)
    if (!group.is_fixed && group.handle < 0)
      add_part({group.name, group.nodes, -1, 0, group.may_rotate, {}});

  // Parts without constraints stay.
  DisjointSets connected(graph.nodes);
  for (const auto& e : graph.edges) connected.unite(e.a, e.b);
  for (const auto& part : u.parts)
    for (const int v : part.nodes) connected.unite(part.nodes.front(), v);
  std::vector<char> is_anchored(graph.nodes, 0);
  for (int v = 0; v < graph.nodes; ++v)
    if (is_constrained[v]) is_anchored[connected.find(v)] = 1;
  for (const auto& d : u.penalized_nodes) is_anchored[connected.find(d.node)] = 1;
  long unconnected = 0;
  for (int v = 0; v < graph.nodes; ++v)
    if (!is_anchored[connected.find(v)]) {
      ++unconnected;
      fixed[v] = is_constrained[v] = 1;
      u.part_of_node[v] = -1;
    }
  std::erase_if(u.parts, [&](const auto& part) { return fixed[part.nodes.front()] != 0; });
  for (int p = 0; p < isize(u.parts); ++p)
    for (const int v : u.parts[p].nodes) u.part_of_node[v] = p;
  if (unconnected > 0)
    u.notes.push_back(std::to_string(unconnected) +
                      " nodes are not connected to a fixed node or handle; they do not move");

  u.unknown_of_node.assign(graph.nodes, -1);
  for (int v = 0; v < graph.nodes; ++v)
    if (!is_constrained[v] && u.part_of_node[v] < 0) u.unknown_of_node[v] = u.count++;
  for (auto& part : u.parts) {
    if (part.handle >= 0) continue;
    part.unknown = u.count++;
    for (const int v : part.nodes) u.unknown_of_node[v] = part.unknown;
  }
  for (int e = 0; e < isize(graph.edges); ++e) {
    const auto& edge = graph.edges[e];
    const int p = u.part_of_node[edge.a], q = u.part_of_node[edge.b];
    const int a = u.unknown_of_node[edge.a], b = u.unknown_of_node[edge.b];
    if (p != q) {
      if (p >= 0) u.parts[p].edges.push_back(e);
      if (q >= 0) u.parts[q].edges.push_back(e);
    }
    if (a != b && (p >= 0 || q >= 0 || a < 0 || b < 0)) u.offset_edges.push_back(e);
  }
  return u;
}

SparseMatrix frame_matrix(const NodeGraph& graph, const FrameUnknowns& u, double penalty_weight) {
  std::vector<Triplet> entries;
  entries.reserve(3 * graph.edges.size() + u.penalized_nodes.size());
  for (const auto& e : graph.edges) {
    const int a = u.unknown_of_node[e.a], b = u.unknown_of_node[e.b];
    if (a == b) continue;
    if (a >= 0) entries.emplace_back(a, a, e.weight);
    if (b >= 0) entries.emplace_back(b, b, e.weight);
    if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -e.weight);
  }
  for (const auto& d : u.penalized_nodes)
    if (const int a = u.unknown_of_node[d.node]; a >= 0) entries.emplace_back(a, a, penalty_weight);
  SparseMatrix K(u.count, u.count);
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

Vec3 centre_of(const std::vector<int>& nodes, const RowPoints& p) {
  Vec3 sum = Vec3::Zero();
  for (const int v : nodes) sum += p.row(v).transpose();
  return nodes.empty() ? sum : sum / static_cast<double>(nodes.size());
}

void fit_free_handles(const std::vector<Handle>& handles, const std::vector<HandlePose>& poses,
                      const RowPoints& rest, const std::vector<Vec3>& centres, const RowPoints& now,
                      std::vector<Mat3>& rotations) {
  for (size_t h = 0; h < handles.size(); ++h) {
    if (!poses[h].free_rotation) continue;
    const Vec3 from = centres[h], to = poses[h].motion(from);
    Mat3 M = Mat3::Zero();
    for (const int v : handles[h].vertices)
      M += (now.row(v).transpose() - to) * (rest.row(v).transpose() - from).transpose();
    rotations[h] = nearest_rotation(M * rotations[h].transpose()) * rotations[h];
  }
}

void spread_rotations(const MatX& handle_weights, const std::vector<HandlePose>& handles,
                      std::vector<Mat3>& rotations) {
  std::vector<Vec3> logs;
  for (const auto& pose : handles) logs.push_back(to_rotation_vector(pose.motion.rotation));
  interpolate_rotations(handle_weights, logs, rotations);
}

}  // namespace batten
