#include "batten/apps/commands/meshes/turn_estimate.h"

#include <algorithm>
#include <memory>
#include <numbers>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/core/each_once.h"
#include "batten/core/groups.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/core/rotations.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/regions/nonlinear_deformer.h"
#include "batten/mesh/rotation_batch.h"
#include "batten/mesh/rotation_of_faces.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

using Turn = EditRule::Turn;

bool moves(const HandleMove& move) {
  return !move.turn.isZero(0) || !move.shift.isZero(0) || move.scale != 1;
}

/// Fixed vertices, and those outside of the region of interest.
std::vector<int> held_of(const DeformProblem& problem, const TriangleMesh& mesh) {
  std::vector<int> fixed = problem.fixed;
  if (!problem.region) return fixed;
  const MeshTopology& topology = mesh.topology();
  std::vector<char> free(mesh.vertex_count(), 0);
  for (const int v : topology.whole_nodes(*problem.region)) free[v] = 1;
  for (const Handle& h : problem.handles)
    for (const int v : topology.whole_nodes(h.vertices)) free[v] = 1;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!free[v] && !topology.neighbours(v).empty()) fixed.push_back(v);
  return fixed;
}

/// Vertices of the parts that something holds, or that `connecting` features hold to these: of the
/// others the estimate knows nothing.
std::vector<char> known_vertices(const std::vector<int>& fixed, const std::vector<Handle>& handles,
                                 const std::vector<FormFeature>& connecting,
                                 const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const std::vector<int> part = parts_of_nodes(topology);
  Groups together(mesh.vertex_count());  // of parts
  for (const FormFeature& f : connecting) {
    int first = -1;
    for (const int v : f.vertices) {
      const int p = part[topology.node_of(v)];
      if (p >= 0 && first >= 0) together.join(first, p);
      if (p >= 0) first = p;
    }
  }
  std::vector<char> held(mesh.vertex_count(), 0);
  const auto hold = [&](int v) {
    if (const int p = part[topology.node_of(v)]; p >= 0) held[together.of(p)] = 1;
  };
  for (const int v : fixed) hold(v);
  for (const Handle& h : handles)
    for (const int v : h.vertices) hold(v);
  std::vector<char> known(mesh.vertex_count(), 0);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (const int p = part[topology.node_of(v)]; p >= 0) known[v] = held[together.of(p)];
  return known;
}

/// Features that turn as one, because they share vertices or are told to.
std::vector<int> turning_groups(const DeformProblem& problem, int vertices) {
  Groups groups(problem.features.size());
  std::vector<int> owner(vertices, -1);
  for (int f = 0; f < count_of(problem.features); ++f)
    for (const int v : problem.features[f].vertices) {
      if (owner[v] >= 0) groups.join(owner[v], f);
      owner[v] = f;
    }
  for (const auto& alike : problem.same_turns)
    for (const int f : alike) groups.join(alike[0], f);
  std::vector<int> group;
  for (int f = 0; f < count_of(problem.features); ++f) group.push_back(groups.of(f));
  return group;
}

}  // namespace

/// How features turn in a shape: the mean of the rotations of faces, those of their own vertices or those
/// beside them. Which faces these are is found once.
class FeatureTurns {
 public:
  enum class Faces { Own, Beside };
  FeatureTurns(const DeformProblem& problem, const TriangleMesh& mesh,
               const std::vector<char>& known, Faces faces)
      : mesh_(mesh), group_(turning_groups(problem, mesh.vertex_count())) {
    triangles_.resize(problem.features.size());
    for (size_t f = 0; f < problem.features.size(); ++f)
      gather_faces(problem.features[f], known, faces, triangles_[group_[f]]);
    for (const auto& triangles : triangles_) {
      areas_.emplace_back();
      for (const int t : triangles) areas_.back().push_back(mesh_.area_vector(t).norm());
    }
    find_held(problem);
  }

  std::vector<std::optional<Mat3>> found(const DeformEdit& edit, const Points& positions) const {
    std::vector<std::optional<Mat3>> of_group(triangles_.size()), turns(group_.size());
    parallel_parts(count_of(triangles_), [&](int g) {
      if (triangles_[g].empty()) return;
      std::vector<Mat3> rotations(triangles_[g].size());
      rotations_of_triangles(mesh_.triangles(), triangles_[g], mesh_.points(), positions,
                             rotations);
      of_group[g] = mean_rotation(rotations, areas_[g]);
    });
    for (size_t f = 0; f < group_.size(); ++f) turns[f] = of_group[group_[f]];
    for (const auto& [feature, handle] : held_)
      set(turns, feature,
          handle >= 0 ? rotation_matrix(edit.handles[handle].turn) : Mat3(Mat3::Identity()));
    return turns;
  }

  void set(std::vector<std::optional<Mat3>>& turns, size_t feature, const Mat3& turn) const {
    for (size_t f = 0; f < turns.size(); ++f)
      if (group_[f] == group_[feature]) turns[f] = turn;
  }

 private:
  /// Triangles of a feature's vertices, and of the ring around it. O(feature): there may be many.
  std::vector<int> triangles_near(const std::vector<int>& own, Faces faces) const {
    const MeshTopology& topology = mesh_.topology();
    std::vector<int> vertices = own, triangles;
    for (size_t i = 0; i < own.size() && faces == Faces::Beside; ++i) {
      const auto ring = topology.neighbours(own[i]);
      vertices.insert(vertices.end(), ring.begin(), ring.end());
    }
    for (const int v : topology.whole_nodes(std::move(vertices))) {
      const auto around = topology.triangles_of(v);
      triangles.insert(triangles.end(), around.begin(), around.end());
    }
    return each_once(std::move(triangles));
  }

  void gather_faces(const FormFeature& feature, const std::vector<char>& known, Faces faces,
                    std::vector<int>& triangles) const {
    const MeshTopology& topology = mesh_.topology();
    const std::vector<int> own = topology.whole_nodes(feature.vertices);
    for (const int t : triangles_near(own, faces)) {
      const auto& corners = topology.triangles()[t];
      const auto all = [&](const auto& condition) {
        return std::all_of(corners.begin(), corners.end(), condition);
      };
      if (!all([&](int v) { return known[v] != 0; })) continue;
      if (faces == Faces::Beside &&
          all([&](int v) { return std::binary_search(own.begin(), own.end(), v); }))
        continue;
      triangles.push_back(t);
    }
  }

  /// What is held turns as it is told, with all that turns as it does.
  void find_held(const DeformProblem& problem) {
    std::vector<int> handle(mesh_.vertex_count(), -1);
    std::vector<char> fixed(mesh_.vertex_count(), 0);
    for (const int v : held_of(problem, mesh_)) fixed[v] = 1;
    for (int h = 0; h < count_of(problem.handles); ++h)
      for (const int v : problem.handles[h].vertices) handle[v] = h;
    for (size_t f = 0; f < problem.features.size(); ++f) {
      const FormFeature& feature = problem.features[f];
      std::optional<int> told;
      for (const int v : feature.vertices)
        if (handle[v] >= 0)
          told = handle[v];
        else if (fixed[v])
          told = -1;
      if (feature.kind == FormFeature::Kind::KeepsDirection) told = -1;
      if (told) held_.emplace_back(f, *told);
    }
  }

  const TriangleMesh& mesh_;
  std::vector<int> group_;
  std::vector<std::vector<int>> triangles_;   // of each group
  std::vector<std::vector<double>> areas_;    // of these
  std::vector<std::pair<size_t, int>> held_;  // features, and the handle that turns them, -1: none
};

namespace {

/// The same edit without features, but for connections between parts.
Task without_features(const Task& task, const TriangleMesh& mesh) {
  Task plain = task;
  const std::vector<int> part = parts_of_nodes(mesh.topology());
  std::erase_if(plain.problem.features, [&](const FormFeature& f) {
    const int first = part[f.vertices[0]];
    return std::all_of(f.vertices.begin(), f.vertices.end(),
                       [&](int v) { return part[v] < 0 || part[v] == first; });
  });
  plain.problem.same_turns.clear();
  plain.problem.guided.clear();
  plain.problem.rows.clear();
  return plain;
}

void set_told(const EditRule& rule, const Task& task, const FeatureTurns& turns,
              std::vector<std::optional<Mat3>>& of) {
  for (const auto& told : rule.turns)
    for (size_t f = 0; f < task.problem.features.size(); ++f)
      if (matches(told.feature.text, task.problem.features[f].name))
        turns.set(of, f,
                  Eigen::AngleAxisd(told.degrees * std::numbers::pi / 180, told.axis).matrix());
}

std::unique_ptr<DeformEstimate> deformer_of(Turn turn, const PreparedMesh& prepared,
                                            const TriangleMesh& mesh, const std::vector<int>& fixed,
                                            const std::vector<Handle>& handles) {
  if (turn == Turn::Nonlinear) return std::make_unique<NonlinearDeformer>(mesh, fixed, handles);
  return std::make_unique<DualLaplacianDeformer>(mesh, polygons_of(prepared), fixed, handles);
}

}  // namespace

TurnFinder::TurnFinder(const PreparedMesh& prepared, const TriangleMesh& mesh)
    : prepared_(prepared), mesh_(mesh) {}
TurnFinder::~TurnFinder() = default;

ShapeEstimate TurnFinder::featureless(const Task& task) {
  if (!plain_) {
    const DeformProblem problem = without_features(task, mesh_).problem;
    plain_ = std::make_unique<FormFeatureDeformer>(mesh_, problem);
    known_ =
        known_vertices(held_of(task.problem, mesh_), task.problem.handles, problem.features, mesh_);
  }
  DeformEdit edit;
  edit.handles = task.edit.handles;
  return {.positions = plain_->deform(edit), .known = known_, .feature_turns = {}};
}

std::optional<ShapeEstimate> TurnFinder::estimate(const EditRule& rule, const Task& task,
                                                  DeformReport::Edit& edit) {
  const DeformProblem& problem = task.problem;
  const bool moving = std::any_of(task.edit.handles.begin(), task.edit.handles.end(), moves);
  const bool finds = moving && rule.turn != Turn::Harmonic;
  if (!finds && rule.turns.empty()) return std::nullopt;
  ShapeEstimate estimate;
  estimate.positions = mesh_.points();
  estimate.known.assign(mesh_.vertex_count(), 0);
  if (finds && rule.turn == Turn::Found) {
    estimate = featureless(task);
  } else if (finds) {
    const std::vector<int> fixed = held_of(problem, mesh_);
    estimate.use = ShapeEstimate::Use::Shape;
    if (!in_rounds_) in_rounds_ = deformer_of(rule.turn, prepared_, mesh_, fixed, problem.handles);
    estimate.positions = in_rounds_->deform(task.edit.handles);
    estimate.known = known_vertices(fixed, problem.handles, {}, mesh_);
    edit.rounds = in_rounds_->report().rounds;
    edit.found = in_rounds_->report().converged;
  }
  if (!own_ || own_finds_ != finds)  // they know other vertices
    own_ = std::make_unique<FeatureTurns>(problem, mesh_, estimate.known, FeatureTurns::Faces::Own);
  own_finds_ = finds;
  estimate.feature_turns = own_->found(task.edit, estimate.positions);
  set_told(rule, task, *own_, estimate.feature_turns);
  return estimate;
}

double TurnFinder::lean_on(const EditRule& rule, const Task& task, size_t leaning,
                           const Points& positions, ShapeEstimate& estimate) {
  if (!beside_) {
    const DeformProblem& problem = task.problem;
    const std::vector<char> held =
        known_vertices(held_of(problem, mesh_), problem.handles, {}, mesh_);
    beside_ = std::make_unique<FeatureTurns>(problem, mesh_, held, FeatureTurns::Faces::Beside);
  }
  auto found = beside_->found(task.edit, positions);
  set_told(rule, task, *beside_, found);
  double largest = 0;
  for (size_t f = 0; f < leaning; ++f) {
    auto& turn = estimate.feature_turns[f];
    if (!found[f] || !turn) continue;
    largest = std::max(largest, Eigen::AngleAxisd(turn->transpose() * *found[f]).angle());
    turn = found[f];
  }
  return largest * 180 / std::numbers::pi;
}

}  // namespace batten
