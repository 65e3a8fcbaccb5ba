// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/editing/feature_rotation_estimator.h"

#include <algorithm>
#include <map>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

bool moves(const HandleTransform& move) {
  return !move.rotation_vector.isZero(0) || !move.translation.isZero(0) || move.scale != 1;
}

/// Fixed vertices, and those outside the region of interest.
std::vector<int> fixed_vertices(const DeformProblem& problem, const TriangleMesh& mesh) {
  std::vector<int> fixed = problem.fixed;
  if (!problem.region) return fixed;
  const MeshTopology& topology = mesh.topology();
  std::vector<char> free(mesh.vertex_count(), 0);
  for (const int v : topology.expand_to_nodes(*problem.region)) free[v] = 1;
  for (const Handle& h : problem.handles)
    for (const int v : topology.expand_to_nodes(h.vertices)) free[v] = 1;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!free[v] && !topology.neighbours(v).empty()) fixed.push_back(v);
  return fixed;
}

/// Vertices of mesh components that are fixed or moved, directly or through `connecting` features.
/// The estimate does not determine the others.
std::vector<char> known_vertices(const std::vector<int>& fixed, const std::vector<Handle>& handles,
                                 const std::vector<FormFeature>& connecting,
                                 const std::vector<LinearConstraint>& ties,
                                 const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const std::vector<int> part = node_components(topology);
  DisjointSets together(mesh.vertex_count());  // of components
  for (const FormFeature& f : connecting) {
    int first = -1;
    for (const int v : f.vertices) {
      const int p = part[topology.node_of(v)];
      if (p >= 0 && first >= 0) together.unite(first, p);
      if (p >= 0) first = p;
    }
  }
  std::map<int, int> pulls;  // per component: constraints of positions
  for (const LinearConstraint& tie : ties) {
    if (!tie.connects) {
      if (const int p = part[topology.node_of(tie.combination.entries[0].vertex)]; p >= 0)
        ++pulls[p];
      continue;
    }
    const int first = part[topology.node_of(tie.combination.entries[0].vertex)];
    for (const auto& e : tie.combination.entries)
      if (const int p = part[topology.node_of(e.vertex)]; first >= 0 && p >= 0)
        together.unite(first, p);
  }
  std::vector<char> constrained(mesh.vertex_count(), 0);
  const auto hold = [&](int v) {
    if (const int p = part[topology.node_of(v)]; p >= 0) constrained[together.find(p)] = 1;
  };
  for (const int v : fixed) hold(v);
  for (const Handle& h : handles)
    for (const int v : h.vertices) hold(v);
  constexpr int enough = 3;  // points determine a position
  for (const auto& [p, count] : pulls)
    if (count >= enough) constrained[together.find(p)] = 1;
  std::vector<char> known(mesh.vertex_count(), 0);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (const int p = part[topology.node_of(v)]; p >= 0) known[v] = constrained[together.find(p)];
  return known;
}

/// Groups of features with a common rotation, because of shared vertices or a relation.
std::vector<int> rotation_groups(const DeformProblem& problem, int vertices) {
  DisjointSets groups(problem.features.size());
  std::vector<int> owner(vertices, -1);
  for (int f = 0; f < isize(problem.features); ++f)
    for (const int v : problem.features[f].vertices) {
      if (owner[v] >= 0) groups.unite(owner[v], f);
      owner[v] = f;
    }
  for (const auto& alike : problem.shared_rotations)
    for (const int f : alike) groups.unite(alike[0], f);
  std::vector<int> group;
  for (int f = 0; f < isize(problem.features); ++f) group.push_back(groups.find(f));
  return group;
}

/// True for an open chain of edges: no triangle has all corners in the feature, and a vertex has only
/// one neighbour there. `own`: vertices of the feature, ascending.
bool is_open_chain(const std::vector<int>& own, const MeshTopology& topology) {
  const auto is_own = [&](int v) { return std::binary_search(own.begin(), own.end(), v); };
  bool has_end = false;
  for (const int v : own) {
    for (const int t : topology.triangles_of(v)) {
      const auto& corners = topology.triangles()[t];
      if (std::all_of(corners.begin(), corners.end(), is_own)) return false;
    }
    const auto ring = topology.neighbours(v);
    has_end = has_end || std::count_if(ring.begin(), ring.end(), is_own) == 1;
  }
  return has_end;
}

/// The same problem without features, except for connections between mesh components.
DeformProblem without_features(const DeformProblem& problem, const TriangleMesh& mesh) {
  DeformProblem plain = problem;
  const std::vector<int> part = node_components(mesh.topology());
  std::erase_if(plain.features, [&](const FormFeature& f) {
    const int first = part[f.vertices[0]];
    return std::all_of(f.vertices.begin(), f.vertices.end(),
                       [&](int v) { return part[v] < 0 || part[v] == first; });
  });
  plain.shared_rotations.clear();
  plain.point_constraints.clear();
  std::erase_if(plain.rows, [](const LinearConstraint& row) { return !row.connects; });
  return plain;
}

std::unique_ptr<IterativeDeformer> deformer_of(RotationMode mode, const PreparedMesh& prepared,
                                               const TriangleMesh& mesh,
                                               const std::vector<int>& fixed,
                                               const std::vector<Handle>& handles,
                                               double tolerance) {
  constexpr int more = 5;  // iterations for a smaller tolerance than the default
  const auto adapted = [&](auto options) {
    if (tolerance < options.tolerance) options.max_iterations *= more;
    options.tolerance = tolerance;
    return options;
  };
  if (mode == RotationMode::Nonlinear)
    return std::make_unique<ArapDeformer>(mesh, fixed, handles, adapted(ArapOptions()));
  return std::make_unique<DualLaplacianDeformer>(mesh, polygons_of(prepared), fixed, handles,
                                                 adapted(DualLaplacianOptions()));
}

void check(std::span<const PrescribedRotation> prescribed, size_t features) {
  for (const PrescribedRotation& p : prescribed)
    if (p.feature < 0 || p.feature >= static_cast<int>(features))
      throw InputError("found a prescribed rotation of feature " + std::to_string(p.feature) +
                       ", expected one of 0 to " + std::to_string(static_cast<long>(features) - 1));
}

}  // namespace

/// Rotations of features in a shape: the mean rotation of their faces, which are determined once.
class FeatureRotationEstimator::Rotations {
 public:
  Rotations(const DeformProblem& problem, const TriangleMesh& mesh, const std::vector<char>& known)
      : mesh_(mesh), group_(rotation_groups(problem, mesh.vertex_count())) {
    triangles_.resize(problem.features.size());
    for (size_t f = 0; f < problem.features.size(); ++f)
      gather_faces(problem.features[f], known, triangles_[group_[f]]);
    for (const auto& triangles : triangles_) {
      areas_.emplace_back();
      for (const int t : triangles) areas_.back().push_back(mesh_.area_vector(t).norm());
    }
    find_constrained(problem);
    for (const FormFeature& feature : problem.features)
      is_chain_.push_back(
          is_open_chain(mesh.topology().expand_to_nodes(feature.vertices), mesh.topology()));
  }

  /// The rotation of each feature in the shape `positions`; none: it has no faces.
  std::vector<std::optional<Mat3>> at(const Points& positions, const DeformEdit& edit,
                                      std::span<const PrescribedRotation> prescribed) const {
    std::vector<std::optional<Mat3>> of_group(triangles_.size()), all(group_.size());
    parallel_for(isize(triangles_), [&](int g) {
      if (triangles_[g].empty()) return;
      std::vector<Mat3> rotations(triangles_[g].size());
      rotations_of_triangles(mesh_.triangles(), triangles_[g], mesh_.points(), positions,
                             rotations);
      of_group[g] = mean_rotation(rotations, areas_[g]);
    });
    for (size_t f = 0; f < group_.size(); ++f) all[f] = of_group[group_[f]];
    for (const auto& [feature, handle] : constrained_)
      set(all, feature,
          handle >= 0 ? rotation_matrix(edit.handles[handle].rotation_vector)
                      : Mat3(Mat3::Identity()));
    for (const PrescribedRotation& p : prescribed) set(all, p.feature, p.rotation);
    return all;
  }

  /// See FeatureRotationEstimator::bodies().
  std::vector<int> bodies(std::span<const PrescribedRotation> prescribed, int count,
                          const std::vector<std::optional<Mat3>>& rotations) const {
    constexpr int none = -1, free = 0;
    std::vector<int> of_group(group_.size(), none), body;
    for (int f = 0; f < count; ++f)
      if (!is_chain_[f]) of_group[group_[f]] = free;
    for (size_t f = 0; f < group_.size(); ++f)
      if (!rotations[f]) of_group[group_[f]] = none;
    for (const auto& [feature, handle] : constrained_) of_group[group_[feature]] = none;
    for (const PrescribedRotation& p : prescribed) of_group[group_[p.feature]] = none;
    int bodies = 0;
    for (int& b : of_group)
      if (b == free) b = bodies++;
    for (const int g : group_) body.push_back(of_group[g]);
    return body;
  }

 private:
  /// Sets the rotation of a feature and of its group.
  void set(std::vector<std::optional<Mat3>>& rotations, int feature, const Mat3& rotation) const {
    for (size_t f = 0; f < rotations.size(); ++f)
      if (group_[f] == group_[feature]) rotations[f] = rotation;
  }

  /// Known triangles at the vertices of a feature. Cost: O(feature), because there may be many
  /// features.
  void gather_faces(const FormFeature& feature, const std::vector<char>& known,
                    std::vector<int>& triangles) const {
    const MeshTopology& topology = mesh_.topology();
    std::vector<int> near;
    for (const int v : topology.expand_to_nodes(feature.vertices)) {
      const auto around = topology.triangles_of(v);
      near.insert(near.end(), around.begin(), around.end());
    }
    for (const int t : sorted_unique(std::move(near))) {
      const auto& corners = topology.triangles()[t];
      if (std::all_of(corners.begin(), corners.end(), [&](int v) { return known[v] != 0; }))
        triangles.push_back(t);
    }
  }

  /// Determines features whose rotation follows from handles or fixed vertices.
  void find_constrained(const DeformProblem& problem) {
    std::vector<int> handle(mesh_.vertex_count(), -1);
    std::vector<char> fixed(mesh_.vertex_count(), 0);
    for (const int v : fixed_vertices(problem, mesh_)) fixed[v] = 1;
    for (int h = 0; h < isize(problem.handles); ++h)
      for (const int v : problem.handles[h].vertices) handle[v] = h;
    for (size_t f = 0; f < problem.features.size(); ++f) {
      const FormFeature& feature = problem.features[f];
      std::optional<int> constrained;
      for (const int v : feature.vertices)
        if (handle[v] >= 0)
          constrained = handle[v];
        else if (fixed[v])
          constrained = -1;
      if (feature.kind == FormFeature::Kind::TranslationOnly) constrained = -1;
      if (constrained) constrained_.emplace_back(static_cast<int>(f), *constrained);
    }
  }

  const TriangleMesh& mesh_;
  std::vector<int> group_;
  std::vector<std::vector<int>> triangles_;  // per group
  std::vector<std::vector<double>> areas_;   // per triangle of these
  /// Features whose rotation is constrained, and the handle that rotates them; -1: none.
  std::vector<std::pair<int, int>> constrained_;
  std::vector<char> is_chain_;  // per feature: is_open_chain()
};

FeatureRotationEstimator::FeatureRotationEstimator(const PreparedMesh& prepared,
                                                   const TriangleMesh& mesh,
                                                   const DeformProblem& problem, RotationMode mode,
                                                   double tolerance)
    : prepared_(prepared), mesh_(mesh), problem_(problem), mode_(mode), tolerance_(tolerance) {}
FeatureRotationEstimator::~FeatureRotationEstimator() = default;

ShapeEstimate FeatureRotationEstimator::featureless(const DeformEdit& edit) {
  if (!featureless_) {
    const DeformProblem problem = without_features(problem_, mesh_);
    featureless_ = std::make_unique<FormFeatureDeformer>(mesh_, problem);
    known_ = known_vertices(fixed_vertices(problem_, mesh_), problem_.handles, problem.features,
                            problem.rows, mesh_);
  }
  DeformEdit plain;
  plain.handles = edit.handles;
  return {.positions = featureless_->deform(plain), .known = known_, .feature_rotations = {}};
}

std::optional<ShapeEstimate> FeatureRotationEstimator::estimate(
    const DeformEdit& edit, std::span<const PrescribedRotation> prescribed, bool pulled) {
  check(prescribed, problem_.features.size());
  iterations_ = 0;
  converged_ = true;
  const bool moving = std::any_of(edit.handles.begin(), edit.handles.end(), moves);
  const bool finds = mode_ == RotationMode::Estimated ? moving || pulled
                                                      : moving && mode_ != RotationMode::Harmonic;
  if (!finds && prescribed.empty()) return std::nullopt;
  ShapeEstimate estimate;
  estimate.positions = mesh_.points();
  estimate.known.assign(mesh_.vertex_count(), 0);
  if (finds && mode_ == RotationMode::Estimated) {
    if (moving)
      estimate = featureless(edit);
    else
      estimate.known = known_vertices(fixed_vertices(problem_, mesh_), problem_.handles,
                                      problem_.features, problem_.rows, mesh_);
  } else if (finds) {
    const std::vector<int> fixed = fixed_vertices(problem_, mesh_);
    estimate.use = ShapeEstimate::Use::Shape;
    if (!iterative_)
      iterative_ = deformer_of(mode_, prepared_, mesh_, fixed, problem_.handles, tolerance_);
    estimate.positions = iterative_->deform(edit.handles);
    estimate.known = known_vertices(fixed, problem_.handles, {}, {}, mesh_);
    iterations_ = iterative_->report().iterations;
    constexpr double invisible = 1e-6;  // also for a smaller tolerance
    converged_ = iterative_->report().last_change < invisible;
  }
  if (!own_ || own_estimated_ != finds)  // the two estimates determine different vertices
    own_ = std::make_unique<Rotations>(problem_, mesh_, estimate.known);
  own_estimated_ = finds;
  estimate.feature_rotations = own_->at(estimate.positions, edit, prescribed);
  return estimate;
}

ShapeEstimate FeatureRotationEstimator::estimate_from(
    const Points& shape, const DeformEdit& edit, std::span<const PrescribedRotation> prescribed) {
  check(prescribed, problem_.features.size());
  ShapeEstimate estimate;
  estimate.use = ShapeEstimate::Use::Shape;
  estimate.positions = shape;
  estimate.known.assign(mesh_.vertex_count(), 1);
  if (!given_) given_ = std::make_unique<Rotations>(problem_, mesh_, estimate.known);
  estimate.feature_rotations = given_->at(shape, edit, prescribed);
  return estimate;
}

std::vector<int> FeatureRotationEstimator::bodies(std::span<const PrescribedRotation> prescribed,
                                                  int count, const ShapeEstimate& estimate) const {
  check(prescribed, problem_.features.size());
  if (!own_ || estimate.feature_rotations.empty())
    return std::vector<int>(problem_.features.size(), -1);
  return own_->bodies(prescribed, count, estimate.feature_rotations);
}

}  // namespace batten
