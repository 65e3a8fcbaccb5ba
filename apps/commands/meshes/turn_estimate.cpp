#include "batten/apps/commands/meshes/turn_estimate.h"

#include <algorithm>
#include <memory>
#include <numbers>

#include "batten/apps/commands/runs/run_parts.h"
#include "batten/core/each_once.h"
#include "batten/core/groups.h"
#include "batten/core/index.h"
#include "batten/core/rotations.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/regions/nonlinear_deformer.h"
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

class FeatureTurns {
 public:
  /// Which faces tell how a feature turns: those of its own vertices, or those beside it.
  enum class Faces { Own, Beside };
  FeatureTurns(const Task& task, const TriangleMesh& mesh, const std::vector<char>& known,
               const Points& positions, Faces faces)
      : problem_(task.problem),
        edit_(task.edit),
        mesh_(mesh),
        known_(known),
        positions_(positions),
        faces_(faces),
        group_(turning_groups(problem_, mesh.vertex_count())) {}

  std::vector<std::optional<Mat3>> found() const {
    const auto count = problem_.features.size();
    std::vector<std::vector<Mat3>> rotations(count);
    std::vector<std::vector<double>> areas(count);
    for (size_t f = 0; f < count; ++f) gather_faces(f, rotations[group_[f]], areas[group_[f]]);
    std::vector<std::optional<Mat3>> turns(count);
    for (size_t f = 0; f < count; ++f) {
      const auto g = static_cast<size_t>(group_[f]);
      if (!rotations[g].empty()) turns[f] = mean_rotation(rotations[g], areas[g]);
    }
    hold(turns);
    return turns;
  }

  void set(std::vector<std::optional<Mat3>>& turns, size_t feature, const Mat3& turn) const {
    for (size_t f = 0; f < turns.size(); ++f)
      if (group_[f] == group_[feature]) turns[f] = turn;
  }

 private:
  /// Triangles of a feature's vertices, and of the ring around it. O(feature): there may be many.
  std::vector<int> triangles_near(const std::vector<int>& own) const {
    const MeshTopology& topology = mesh_.topology();
    std::vector<int> vertices = own, triangles;
    for (size_t i = 0; i < own.size() && faces_ == Faces::Beside; ++i) {
      const auto ring = topology.neighbours(own[i]);
      vertices.insert(vertices.end(), ring.begin(), ring.end());
    }
    for (const int v : topology.whole_nodes(std::move(vertices))) {
      const auto around = topology.triangles_of(v);
      triangles.insert(triangles.end(), around.begin(), around.end());
    }
    return each_once(std::move(triangles));
  }

  void gather_faces(size_t f, std::vector<Mat3>& rotations, std::vector<double>& areas) const {
    const MeshTopology& topology = mesh_.topology();
    const std::vector<int> own = topology.whole_nodes(problem_.features[f].vertices);
    const bool beside = faces_ == Faces::Beside;
    for (const int t : triangles_near(own)) {
      const auto& corners = topology.triangles()[t];
      const auto all = [&](const auto& condition) {
        return std::all_of(corners.begin(), corners.end(), condition);
      };
      if (!all([&](int v) { return known_[v] != 0; })) continue;
      if (beside && all([&](int v) { return std::binary_search(own.begin(), own.end(), v); }))
        continue;
      rotations.push_back(rotation_of_face(corners, mesh_.points(), positions_));
      areas.push_back(mesh_.area_vector(t).norm());
    }
  }

  /// What is held turns as it is told, with all that turns as it does.
  void hold(std::vector<std::optional<Mat3>>& turns) const {
    std::vector<int> handle(mesh_.vertex_count(), -1);
    std::vector<char> fixed(mesh_.vertex_count(), 0);
    for (const int v : held_of(problem_, mesh_)) fixed[v] = 1;
    for (int h = 0; h < count_of(problem_.handles); ++h)
      for (const int v : problem_.handles[h].vertices) handle[v] = h;
    for (size_t f = 0; f < turns.size(); ++f) {
      const FormFeature& feature = problem_.features[f];
      std::optional<Mat3> told;
      for (const int v : feature.vertices)
        if (handle[v] >= 0)
          told = rotation_matrix(edit_.handles[handle[v]].turn);
        else if (fixed[v])
          told = Mat3::Identity();
      if (feature.kind == FormFeature::Kind::KeepsDirection) told = Mat3::Identity();
      if (told) set(turns, f, *told);
    }
  }

  const DeformProblem& problem_;
  const DeformEdit& edit_;
  const TriangleMesh& mesh_;
  const std::vector<char>& known_;
  const Points& positions_;
  Faces faces_;
  std::vector<int> group_;
};

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
  const FeatureTurns turns(task, mesh_, estimate.known, estimate.positions,
                           FeatureTurns::Faces::Own);
  estimate.feature_turns = turns.found();
  set_told(rule, task, turns, estimate.feature_turns);
  return estimate;
}

double TurnFinder::lean_on(const EditRule& rule, const Task& task, size_t leaning,
                           const Points& positions, ShapeEstimate& estimate) const {
  const std::vector<char> held =
      known_vertices(held_of(task.problem, mesh_), task.problem.handles, {}, mesh_);
  const FeatureTurns turns(task, mesh_, held, positions, FeatureTurns::Faces::Beside);
  auto found = turns.found();
  set_told(rule, task, turns, found);
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
