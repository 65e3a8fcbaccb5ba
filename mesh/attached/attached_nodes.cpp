// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/attached/attached_nodes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

bool vertices_on_line(const std::vector<int>& vertices, const Points& points) {
  if (vertices.size() < 3) return true;
  Vec3 mean = Vec3::Zero();
  for (const int v : vertices) mean += points.row(v).transpose();
  mean /= static_cast<double>(vertices.size());
  Mat3 scatter = Mat3::Zero();
  for (const int v : vertices) {
    const Vec3 d = points.row(v).transpose() - mean;
    scatter += d * d.transpose();
  }
  const Vec3 widths = Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvalues();
  return !(widths[1] > 1e-12 * widths[2]);
}

/// Best rotation of the vertices, with that about their line, if they lie on one, like `mean`.
Mat3 rotation_from(const Mat3& mean, const std::vector<int>& vertices, const Points& before,
                   const Points& after) {
  Points from(isize(vertices), 3), to(isize(vertices), 3);
  std::vector<int> all;
  for (int i = 0; i < isize(vertices); ++i) {
    from.row(i) = (mean * before.row(vertices[i]).transpose()).transpose();
    to.row(i) = after.row(vertices[i]);
    all.push_back(i);
  }
  return fit_similarity(from, to, all).R * mean;
}

}  // namespace

AttachedNodes::AttachedNodes(std::span<const NonShellElement> elements, const TriangleMesh& mesh,
                             const AttachmentOptions& options, std::span<const SurfaceTie> ties,
                             std::span<const int> face_of_triangle)
    : elements_(elements),
      mesh_(mesh),
      options_(options),
      ties_(ties, elements, mesh, face_of_triangle) {
  const MeshTopology& topology = mesh.topology();
  for (int v = 0; v < topology.node_count(); ++v)
    has_face_.push_back(!topology.neighbours(v).empty());
  connections_ = batten::connections(elements, has_face_, options);
  connections_.insert(connections_.end(), ties_.welds().begin(), ties_.welds().end());
  std::vector<char> taken = has_face_;
  for (const FormFeature& c : connections_)
    for (const int v : c.vertices) taken[v] = 1;
  for (const NonShellElement& e : elements)
    for (const int v : e.nodes)
      if (!taken[v]) free_nodes_.push_back(v);
  for (const TiedNode& tied : ties_.nodes())
    if (!taken[tied.node]) free_nodes_.push_back(tied.node);
  free_nodes_ = sorted_unique(std::move(free_nodes_));
}

void AttachedNodes::add_to(DeformProblem& problem, const Points& points) const {
  problem.features.insert(problem.features.end(), connections_.begin(), connections_.end());
  const auto rows = ties_.constraints(mesh_, points, problem.weighting);
  problem.rows.insert(problem.rows.end(), rows.begin(), rows.end());
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
  for (const TiedNode& tied : ties_.nodes())
    if (!in[tied.node] &&
        std::any_of(tied.corners.begin(), tied.corners.end(), [&](int v) { return in[v] != 0; }))
      region.push_back(tied.node);
}

Mat3 AttachedNodes::ring_rotation(int node, const Points& before, const Points& after) const {
  const MeshTopology& topology = mesh_.topology();
  std::vector<int> ring{node};
  for (const int v : topology.coincident_vertices(node))
    ring.insert(ring.end(), topology.neighbours(v).begin(), topology.neighbours(v).end());
  const bool moved =
      std::any_of(ring.begin(), ring.end(), [&](int v) { return before.row(v) != after.row(v); });
  return moved ? rotation_of_face(ring, before, after) : Mat3(Mat3::Identity());
}

std::vector<Mat3> AttachedNodes::rotations(const Points& before, const Points& after,
                                           const std::vector<FormFeature>& features) const {
  std::vector<Mat3> rotations(has_face_.size(), Mat3::Identity());
  std::vector<char> known(has_face_.size(), 0);
  // Nodes of shells rotate like the ring of faces around them.
  const auto add = [&](int node) {
    if (known[node] || !has_face_[node]) return;
    known[node] = 1;
    rotations[node] = ring_rotation(node, before, after);
  };
  for (const FormFeature& f : features) {
    // Two nodes leave the rotation about their line free: there the shells decide.
    Mat3 mean = Mat3::Identity();
    if (vertices_on_line(f.vertices, before)) {
      Mat3 sum = Mat3::Zero();
      bool rotates = false;
      for (const int v : f.vertices) {
        if (!has_face_[v]) continue;
        sum += ring_rotation(v, before, after);
        rotates |= ring_rotation(v, before, after) != Mat3::Identity();
      }
      if (rotates) mean = nearest_rotation(sum);
    }
    const bool moved = std::any_of(f.vertices.begin(), f.vertices.end(),
                                   [&](int v) { return before.row(v) != after.row(v); });
    const Mat3 R = moved ? rotation_from(mean, f.vertices, before, after) : mean;
    for (const int v : f.vertices) {
      rotations[v] = R;
      known[v] = 1;
    }
  }
  for (const NonShellElement& e : elements_)
    for (const int node : e.nodes) add(node);
  return rotations;
}

void AttachedNodes::place_tied_nodes(const Points& before, Points& after,
                                     const DeformProblem& problem, std::vector<char>& placed,
                                     std::vector<Mat3>& rotations) const {
  if (ties_.nodes().empty()) return;
  std::vector<char> held(has_face_.size(), problem.region ? 1 : 0);
  const auto hold = [&](const std::vector<int>& vertices, char value) {
    for (const int v : vertices) held[mesh_.topology().node_of(v)] = value;
  };
  if (problem.region) hold(*problem.region, 0);
  hold(problem.fixed, 1);
  for (const Handle& h : problem.handles) hold(h.vertices, 1);
  for (const FormFeature& f : problem.features) hold(f.vertices, 1);
  for (const CharacterChain& c : problem.chains) hold(c.vertices, 1);
  for (const LinearConstraint& row : problem.rows)
    for (const auto& e : row.combination.entries)
      if (!row.connects) held[mesh_.topology().node_of(e.vertex)] = 1;
  const auto place = [&](const TiedNode& tied) {
    const auto& c = tied.corners;
    const bool moved =
        std::any_of(c.begin(), c.end(), [&](int v) { return before.row(v) != after.row(v); });
    Mat3 sum = Mat3::Zero();
    for (int k = 0; k < 3; ++k)
      if (moved && tied.weights[k] > 0) sum += tied.weights[k] * ring_rotation(c[k], before, after);
    const Mat3 R = moved ? nearest_rotation(sum) : Mat3(Mat3::Identity());
    const Vec3 gap = before.row(tied.node).transpose() - tied.foot(before);
    const Vec3 at =
        moved ? Vec3(tied.foot(after) + R * gap) : Vec3(before.row(tied.node).transpose());
    for (const int v : mesh_.topology().coincident_vertices(tied.node))
      after.row(v) = at.transpose();
    placed[tied.node] = 1;
    rotations[tied.node] = R;
  };
  // First the shells, to which other nodes may be tied.
  for (const bool shells : {true, false})
    for (const TiedNode& tied : ties_.nodes()) {
      const bool of_shell = has_face_[tied.node] != 0;
      if (of_shell == shells && !(of_shell ? held[tied.node] : placed[tied.node])) place(tied);
    }
}

void AttachedNodes::propagate(const Points& before, Points& after,
                              const DeformProblem& problem) const {
  if (free_nodes_.empty() && ties_.nodes().empty()) return;
  std::vector<char> placed = has_face_;
  for (const FormFeature& f : problem.features)
    for (const int v : f.vertices) placed[v] = 1;
  std::vector<Mat3> turns(has_face_.size(), Mat3::Identity());
  place_tied_nodes(before, after, problem, placed, turns);
  if (free_nodes_.empty()) return;
  std::vector<Mat3> known = rotations(before, after, problem.features);
  for (const TiedNode& tied : ties_.nodes())
    if (!has_face_[tied.node]) known[tied.node] = turns[tied.node];
  propagate_to_attached(before, after, std::move(placed), std::move(known), elements_, options_);
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
  motion.tied_nodes = isize(ties_.nodes());
  for (const TiedNode& tied : ties_.nodes()) {
    const auto distance = [&](const Points& p) {
      return (p.row(tied.node).transpose() - tied.foot(p)).norm();
    };
    const double change = std::abs(distance(after) - distance(before));
    if (change > motion.max_gap_change) {
      motion.max_gap_change = change;
      motion.worst_tie = ties_.name(tied.tie);
    }
  }
  for (const int v : free_nodes_) motion.moved_nodes += before.row(v) != after.row(v);
  motion.inverted_solids = inverted_solids(elements_, before, after);
  return motion;
}

}  // namespace batten
