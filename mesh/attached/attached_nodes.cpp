// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/attached/attached_nodes.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

AttachedNodes::AttachedNodes(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                             const AttachmentOptions& options)
    : elements_(elements), mesh_(mesh), options_(options) {
  const MeshTopology& topology = mesh.topology();
  for (int v = 0; v < topology.node_count(); ++v)
    has_face_.push_back(!topology.neighbours(v).empty());
  connections_ = batten::connections(elements, has_face_, options);
  std::vector<char> taken = has_face_;
  for (const FormFeature& c : connections_)
    for (const int v : c.vertices) taken[v] = 1;
  for (const NonShellElement& e : elements)
    for (const int v : e.nodes)
      if (!taken[v]) free_nodes_.push_back(v);
  free_nodes_ = sorted_unique(std::move(free_nodes_));
}

void AttachedNodes::add_to(DeformProblem& problem) const {
  problem.features.insert(problem.features.end(), connections_.begin(), connections_.end());
  if (problem.region) extend_region(*problem.region, problem.handles);
}

void AttachedNodes::extend_region(std::vector<int>& region,
                                  const std::vector<Handle>& handles) const {
  std::vector<char> in(has_face_.size(), 0);
  for (const int v : region) in[mesh_.topology().node_of(v)] = 1;
  for (const Handle& h : handles)
    for (const int v : h.vertices) in[mesh_.topology().node_of(v)] = 1;
  for (const FormFeature& c : connections_)
    if (std::any_of(c.vertices.begin(), c.vertices.end(), [&](int v) { return in[v] != 0; }))
      for (const int v : c.vertices)
        if (!has_face_[v] && !in[v]) region.push_back(v);
}

std::vector<Mat3> AttachedNodes::rotations(const Points& before, const Points& after,
                                           const std::vector<FormFeature>& features) const {
  const MeshTopology& topology = mesh_.topology();
  std::vector<Mat3> rotations(has_face_.size(), Mat3::Identity());
  std::vector<char> known(has_face_.size(), 0);
  for (const FormFeature& f : features) {
    const Mat3 R = fit_similarity(before, after, f.vertices).R;
    for (const int v : f.vertices) {
      rotations[v] = R;
      known[v] = 1;
    }
  }
  // Nodes of shells rotate like the ring of faces around them.
  for (const NonShellElement& e : elements_)
    for (const int node : e.nodes) {
      if (known[node] || !has_face_[node]) continue;
      known[node] = 1;
      std::vector<int> ring{node};
      for (const int v : topology.coincident_vertices(node))
        ring.insert(ring.end(), topology.neighbours(v).begin(), topology.neighbours(v).end());
      rotations[node] = rotation_of_face(ring, before, after);
    }
  return rotations;
}

void AttachedNodes::propagate(const Points& before, Points& after,
                              const std::vector<FormFeature>& features) const {
  if (free_nodes_.empty()) return;
  std::vector<char> placed = has_face_;
  for (const FormFeature& f : features)
    for (const int v : f.vertices) placed[v] = 1;
  propagate_to_attached(before, after, std::move(placed), rotations(before, after, features),
                        elements_, options_);
}

AttachedMotion AttachedNodes::motion(const Points& before, const Points& after) const {
  AttachedMotion motion;
  motion.connections = isize(connections_);
  for (const FormFeature& c : connections_) {
    // Zero-length bushes have no size.
    const Similarity fit = fit_similarity(before, after, c.vertices, 1);
    Box3 box;
    for (const int v : c.vertices) box.extend(before.row(v).transpose());
    const double error = fit.max_error * std::max(box.diagonal().norm(), 0.0);
    if (error > motion.max_rigid_error || std::isnan(error)) {
      motion.max_rigid_error = error;
      motion.worst_connection = c.name;
    }
  }
  for (const int v : free_nodes_) motion.moved_nodes += before.row(v) != after.row(v);
  motion.inverted_solids = inverted_solids(elements_, before, after);
  return motion;
}

}  // namespace batten
