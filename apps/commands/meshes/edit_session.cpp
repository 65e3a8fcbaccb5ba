#include "batten/apps/commands/meshes/edit_session.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <numbers>

#include "batten/apps/commands/runs/run_support.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/mesh/regions/arap_deformer.h"
#include "batten/mesh/regions/dual_laplacian_deformer.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kConvergedDegrees = 0.05;  // degrees

/// Restores coordinates that changed by rounding only, so that their text in the file stays.
Points restore_unmoved(const Points& before, const Points& after) {
  const double rounding =
      16 * std::numeric_limits<double>::epsilon() * before.cwiseAbs().maxCoeff();
  return ((after - before).array().abs() <= rounding).select(before, after);
}

bool scales_features(const DeformEdit& edit) {
  return std::any_of(edit.feature_scales.begin(), edit.feature_scales.end(),
                     [](double scale) { return scale != 1; });
}

void count_into(DeformReport::Edit& report, const FormFeatureDeformer& deformer) {
  const auto c = deformer.counts();
  report.moving = c.moving;
  report.unknowns = c.unknowns;
  report.soft_equations = c.soft_equations;
  report.hard_constraints = c.hard_constraints;
  report.feature_constraints = c.feature_constraints;
  report.redundant_count = c.redundant_count;
  report.point_equations = c.point_equations;
  report.hard_residual = deformer.hard_residual();
}

}  // namespace

template <class Function>
void EditSession::with_edit_context(const Function& f) const {
  const auto fail = [&](const std::string& why) {
    return scene_.at(rule_.location) + "the edit '" + rule_.name + "': " + why;
  };
  try {
    f();
  } catch (const ConflictError& e) {
    throw ConflictError(e.conflicts(), fail(""));
  } catch (const InputError& e) {
    throw InputError(fail(e.what()));
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(fail(e.what()));
  }
}

EditSession::EditSession(const DeformScene& scene, const EditSpec& rule,
                         const SharedConstraints& shared, VertexSelector& select,
                         const PreparedMesh& prepared, const Points& before)
    : scene_(scene),
      rule_(rule),
      shared_(shared),
      prepared_(prepared),
      mesh_(prepared.mesh.with_points(before)),
      rotations_(prepared_, mesh_),
      task_(make_deform_task(scene, rule, shared, select, mesh_)),
      shape_(before) {
  with_edit_context([&] { set_up(); });
}

// Without constraints on feature centres: these need a solved shape first.
void EditSession::set_up() {
  const auto start = Clock::now();
  deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
  centres_kept_ = false;
  set_up_s_ += seconds_since(start);
}

void EditSession::set(const EditSpec& rule) {
  task_.edit = edit_of(scene_, rule, shared_, task_.problem, mesh_);
  rule_ = rule;
  if (!centres_kept_) return;
  task_.problem.rows = shared_.rows;
  set_up();
}

const Points& EditSession::solve_preview() {
  with_edit_context([&] {
    DeformReport::Edit none;
    at_rest_ = true;
    const bool uses_adjacent_faces = rule_.rotation_mode == EditSpec::RotationMode::Estimated &&
                                     shared_.attached->connections().empty();
    if (live_ && uses_adjacent_faces)
      at_rest_ = rotations_.update_from_adjacent_faces(rule_, task_, shared_.features.size(),
                                                       shape_, *live_) < kConvergedDegrees;
    else
      live_ = rotations_.estimate(rule_, task_, none);
    shape_ = live_ ? deformer_->deform(task_.edit, *live_) : deformer_->deform(task_.edit);
  });
  return shape_;
}

const Points& EditSession::solve_to_equilibrium(DeformReport::Edit& report) {
  report.name = rule_.name;
  live_.reset();
  with_edit_context([&] {
    auto start = Clock::now();
    std::optional<ShapeEstimate> estimate = rotations_.estimate(rule_, task_, report);
    report.setup_s = set_up_s_ + seconds_since(start);
    start = Clock::now();
    if (!centres_kept_ && rule_.keep_centres && scales_features(task_.edit)) {
      const std::vector<double> scales = std::move(task_.edit.feature_scales);
      task_.edit.feature_scales.clear();
      converge_rotations(estimate, report);
      task_.edit.feature_scales = scales;
      task_ = with_fixed_centres(std::move(task_), shared_, deformer_->positions());
      deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, task_.problem);
      centres_kept_ = true;
    }
    converge_rotations(estimate, report);
    report.edit_s = seconds_since(start);
    report.last_correction = deformer_->correct();
    count_into(report, *deformer_);
    const Points& found = deformer_->positions();
    report.largest_displacement = (found - before()).rowwise().norm().maxCoeff();
    shape_ = restore_unmoved(before(), found);
    shared_.attached->propagate_to_attached(before(), shape_, task_.problem.features);
  });
  return shape_;
}

// Iterates, because features rotate like the adjacent sheet, which they bend themselves.
void EditSession::converge_rotations(std::optional<ShapeEstimate>& estimate,
                                     DeformReport::Edit& report) {
  estimate ? deformer_->deform(task_.edit, *estimate) : deformer_->deform(task_.edit);
  constexpr int max_iterations = 20;
  if (estimate && rule_.rotation_mode == EditSpec::RotationMode::Estimated) {
    report.found = false;
    for (report.iterations = 1; report.iterations < max_iterations && !report.found;
         ++report.iterations) {
      report.found = rotations_.update_from_adjacent_faces(rule_, task_, shared_.features.size(),
                                                           deformer_->positions(),
                                                           *estimate) < kConvergedDegrees;
      deformer_->deform(task_.edit, *estimate);
    }
  }
  deformer_->correct();
}

namespace {

using RotationMode = EditSpec::RotationMode;

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
  std::vector<char> constrained(mesh.vertex_count(), 0);
  const auto hold = [&](int v) {
    if (const int p = part[topology.node_of(v)]; p >= 0) constrained[together.find(p)] = 1;
  };
  for (const int v : fixed) hold(v);
  for (const Handle& h : handles)
    for (const int v : h.vertices) hold(v);
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

}  // namespace

/// Rotations of features in a shape: the mean rotation of faces, either of their own vertices or of
/// the adjacent ones. The faces are determined once.
class FeatureRotations {
 public:
  enum class Faces { Own, Adjacent };
  FeatureRotations(const DeformProblem& problem, const TriangleMesh& mesh,
                   const std::vector<char>& known, Faces faces)
      : mesh_(mesh), group_(rotation_groups(problem, mesh.vertex_count())) {
    triangles_.resize(problem.features.size());
    for (size_t f = 0; f < problem.features.size(); ++f)
      gather_faces(problem.features[f], known, faces, triangles_[group_[f]]);
    for (const auto& triangles : triangles_) {
      areas_.emplace_back();
      for (const int t : triangles) areas_.back().push_back(mesh_.area_vector(t).norm());
    }
    find_prescribed(problem);
  }

  std::vector<std::optional<Mat3>> found(const DeformEdit& edit, const Points& positions) const {
    std::vector<std::optional<Mat3>> of_group(triangles_.size()), turns(group_.size());
    parallel_for(isize(triangles_), [&](int g) {
      if (triangles_[g].empty()) return;
      std::vector<Mat3> rotations(triangles_[g].size());
      rotations_of_triangles(mesh_.triangles(), triangles_[g], mesh_.points(), positions,
                             rotations);
      of_group[g] = mean_rotation(rotations, areas_[g]);
    });
    for (size_t f = 0; f < group_.size(); ++f) turns[f] = of_group[group_[f]];
    for (const auto& [feature, handle] : prescribed_)
      set(turns, feature,
          handle >= 0 ? rotation_matrix(edit.handles[handle].rotation_vector)
                      : Mat3(Mat3::Identity()));
    return turns;
  }

  void set(std::vector<std::optional<Mat3>>& turns, size_t feature, const Mat3& rotation) const {
    for (size_t f = 0; f < turns.size(); ++f)
      if (group_[f] == group_[feature]) turns[f] = rotation;
  }

 private:
  /// Triangles at the vertices of a feature, or in the rings around it. Cost: O(feature), because
  /// there may be many features.
  std::vector<int> triangles_near(const std::vector<int>& own, Faces faces) const {
    const MeshTopology& topology = mesh_.topology();
    std::vector<int> vertices = own, triangles;
    for (size_t i = 0; i < own.size() && faces == Faces::Adjacent; ++i) {
      const auto ring = topology.neighbours(own[i]);
      vertices.insert(vertices.end(), ring.begin(), ring.end());
    }
    for (const int v : topology.expand_to_nodes(std::move(vertices))) {
      const auto around = topology.triangles_of(v);
      triangles.insert(triangles.end(), around.begin(), around.end());
    }
    return sorted_unique(std::move(triangles));
  }

  void gather_faces(const FormFeature& feature, const std::vector<char>& known, Faces faces,
                    std::vector<int>& triangles) const {
    const MeshTopology& topology = mesh_.topology();
    const std::vector<int> own = topology.expand_to_nodes(feature.vertices);
    for (const int t : triangles_near(own, faces)) {
      const auto& corners = topology.triangles()[t];
      const auto all = [&](const auto& condition) {
        return std::all_of(corners.begin(), corners.end(), condition);
      };
      if (!all([&](int v) { return known[v] != 0; })) continue;
      if (faces == Faces::Adjacent &&
          all([&](int v) { return std::binary_search(own.begin(), own.end(), v); }))
        continue;
      triangles.push_back(t);
    }
  }

  /// Determines prescribed rotations: those of handles and fixed vertices, and of everything
  /// coupled to them.
  void find_prescribed(const DeformProblem& problem) {
    std::vector<int> handle(mesh_.vertex_count(), -1);
    std::vector<char> fixed(mesh_.vertex_count(), 0);
    for (const int v : fixed_vertices(problem, mesh_)) fixed[v] = 1;
    for (int h = 0; h < isize(problem.handles); ++h)
      for (const int v : problem.handles[h].vertices) handle[v] = h;
    for (size_t f = 0; f < problem.features.size(); ++f) {
      const FormFeature& feature = problem.features[f];
      std::optional<int> prescribed;
      for (const int v : feature.vertices)
        if (handle[v] >= 0)
          prescribed = handle[v];
        else if (fixed[v])
          prescribed = -1;
      if (feature.kind == FormFeature::Kind::TranslationOnly) prescribed = -1;
      if (prescribed) prescribed_.emplace_back(f, *prescribed);
    }
  }

  const TriangleMesh& mesh_;
  std::vector<int> group_;
  std::vector<std::vector<int>> triangles_;  // per group
  std::vector<std::vector<double>> areas_;   // per triangle of these
  /// Features with a prescribed rotation, and the handle that rotates them; -1: none.
  std::vector<std::pair<size_t, int>> prescribed_;
};

namespace {

/// The same edit without features, except for connections between mesh components.
DeformTask without_features(const DeformTask& task, const TriangleMesh& mesh) {
  DeformTask plain = task;
  const std::vector<int> part = node_components(mesh.topology());
  std::erase_if(plain.problem.features, [&](const FormFeature& f) {
    const int first = part[f.vertices[0]];
    return std::all_of(f.vertices.begin(), f.vertices.end(),
                       [&](int v) { return part[v] < 0 || part[v] == first; });
  });
  plain.problem.shared_rotations.clear();
  plain.problem.point_constraints.clear();
  plain.problem.rows.clear();
  return plain;
}

void set_prescribed(const EditSpec& rule, const DeformTask& task, const FeatureRotations& turns,
                    std::vector<std::optional<Mat3>>& of) {
  for (const auto& prescribed : rule.rotated_features)
    for (size_t f = 0; f < task.problem.features.size(); ++f)
      if (matches_wildcard(prescribed.feature.text, task.problem.features[f].name))
        turns.set(of, f,
                  Eigen::AngleAxisd(prescribed.degrees * std::numbers::pi / 180, prescribed.axis)
                      .matrix());
}

std::unique_ptr<IterativeDeformer> deformer_of(RotationMode turn, const PreparedMesh& prepared,
                                               const TriangleMesh& mesh,
                                               const std::vector<int>& fixed,
                                               const std::vector<Handle>& handles) {
  if (turn == RotationMode::Nonlinear) return std::make_unique<ArapDeformer>(mesh, fixed, handles);
  return std::make_unique<DualLaplacianDeformer>(mesh, polygons_of(prepared), fixed, handles);
}

}  // namespace

FeatureRotationEstimator::FeatureRotationEstimator(const PreparedMesh& prepared,
                                                   const TriangleMesh& mesh)
    : prepared_(prepared), mesh_(mesh) {}
FeatureRotationEstimator::~FeatureRotationEstimator() = default;

ShapeEstimate FeatureRotationEstimator::featureless(const DeformTask& task) {
  if (!featureless_) {
    const DeformProblem problem = without_features(task, mesh_).problem;
    featureless_ = std::make_unique<FormFeatureDeformer>(mesh_, problem);
    known_ = known_vertices(fixed_vertices(task.problem, mesh_), task.problem.handles,
                            problem.features, mesh_);
  }
  DeformEdit edit;
  edit.handles = task.edit.handles;
  return {.positions = featureless_->deform(edit), .known = known_, .feature_rotations = {}};
}

std::optional<ShapeEstimate> FeatureRotationEstimator::estimate(const EditSpec& rule,
                                                                const DeformTask& task,
                                                                DeformReport::Edit& edit) {
  const DeformProblem& problem = task.problem;
  const bool moving = std::any_of(task.edit.handles.begin(), task.edit.handles.end(), moves);
  const bool finds = moving && rule.rotation_mode != RotationMode::Harmonic;
  if (!finds && rule.rotated_features.empty()) return std::nullopt;
  ShapeEstimate estimate;
  estimate.positions = mesh_.points();
  estimate.known.assign(mesh_.vertex_count(), 0);
  if (finds && rule.rotation_mode == RotationMode::Estimated) {
    estimate = featureless(task);
  } else if (finds) {
    const std::vector<int> fixed = fixed_vertices(problem, mesh_);
    estimate.use = ShapeEstimate::Use::Shape;
    if (!iterative_)
      iterative_ = deformer_of(rule.rotation_mode, prepared_, mesh_, fixed, problem.handles);
    estimate.positions = iterative_->deform(task.edit.handles);
    estimate.known = known_vertices(fixed, problem.handles, {}, mesh_);
    edit.iterations = iterative_->report().iterations;
    edit.found = iterative_->report().converged;
  }
  if (!own_ || own_estimated_ != finds)  // the two estimates determine different vertices
    own_ = std::make_unique<FeatureRotations>(problem, mesh_, estimate.known,
                                              FeatureRotations::Faces::Own);
  own_estimated_ = finds;
  estimate.feature_rotations = own_->found(task.edit, estimate.positions);
  set_prescribed(rule, task, *own_, estimate.feature_rotations);
  return estimate;
}

double FeatureRotationEstimator::update_from_adjacent_faces(const EditSpec& rule,
                                                            const DeformTask& task, size_t count,
                                                            const Points& positions,
                                                            ShapeEstimate& estimate) {
  if (!adjacent_) {
    const DeformProblem& problem = task.problem;
    const std::vector<char> constrained =
        known_vertices(fixed_vertices(problem, mesh_), problem.handles, {}, mesh_);
    adjacent_ = std::make_unique<FeatureRotations>(problem, mesh_, constrained,
                                                   FeatureRotations::Faces::Adjacent);
  }
  auto found = adjacent_->found(task.edit, positions);
  set_prescribed(rule, task, *adjacent_, found);
  double largest = 0;
  for (size_t f = 0; f < count; ++f) {
    auto& rotation = estimate.feature_rotations[f];
    if (!found[f] || !rotation) continue;
    largest = std::max(largest, Eigen::AngleAxisd(rotation->transpose() * *found[f]).angle());
    rotation = found[f];
  }
  return largest * 180 / std::numbers::pi;
}

}  // namespace batten
