// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/edit_session.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/editing/feature_relation.h"
#include "batten/mesh/selection.h"
#include "batten/scenes/meshes/driving_curve.h"
#include "batten/scenes/runs/run_support.h"

namespace batten {

MeshSource read_source(const std::filesystem::path& path) {
  MeshFile file = MeshFile::read(path);
  try {
    PreparedMesh prepared =
        prepare(file.shells(), [&](int v) { return std::to_string(file.node_label(v)); });
    return {std::move(file), std::move(prepared)};
  } catch (const InputError& e) {
    throw InputError(path.string() + ": " + e.what());
  }
}

Points node_positions(const Points& vertices, const MeshFile& file) {
  return vertices.topRows(file.shells().node_count());
}

std::vector<int> vertices_of(const LocatedString& name, const SharedConstraints& shared,
                             VertexSelector& select) {
  const auto feature = std::find_if(shared.features.begin(), shared.features.end(),
                                    [&](const auto& f) { return f.name == name.text; });
  return feature != shared.features.end() ? feature->vertices : select.of(name);
}

namespace {

double chain_length(const TriangleMesh& mesh, const std::vector<int>& chain, bool closed) {
  double sum = 0;
  for (size_t i = 0; i + 1 < chain.size() + (closed ? 1 : 0); ++i)
    sum += (mesh.point(chain[(i + 1) % chain.size()]) - mesh.point(chain[i])).norm();
  return sum;
}

void check_chain(const std::string& name, const std::vector<int>& chain, bool rigid) {
  const size_t different = std::set<int>(chain.begin(), chain.end()).size();
  if (different < 3 || (!rigid && different < chain.size()))
    throw InputError("the chain '" + name + "': found " + std::to_string(chain.size()) +
                     " nodes, " + std::to_string(different) +
                     " of them different, expected at least three, each once");
}

/// Collects form features, single ones and several of one kind.
void gather_features(const DeformScene& scene, VertexSelector& select, SharedConstraints& shared) {
  const auto taken = [&](const std::string& name) {
    return std::any_of(shared.features.begin(), shared.features.end(),
                       [&](const auto& f) { return f.name == name; });
  };
  for (const FeatureSpec& rule : scene.features) {
    if (!rule.name.empty()) {
      shared.features.push_back({rule.name, select.of(rule.vertices), rule.kind});
      continue;
    }
    for (const LocatedString& word : rule.vertices)
      for (const LocatedString& name : select.matching(word)) {
        if (taken(name.text))
          throw InputError(scene.at(word.location) + "found the feature '" + name.text +
                           "' again, expected each feature once");
        shared.features.push_back({name.text, select.of(name), rule.kind});
      }
  }
}

/// Collects constraints to planes and axes: of the loops of proposals, of all vertices of features
/// and selections.
void gather_guides(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                   SharedConstraints& shared) {
  for (const GuideSpec& rule : scene.guides) {
    std::vector<int> vertices;
    const DetectedFeature* p = select.proposal(rule.of.text);
    vertices = p ? mesh.topology().nodes_of(p->loop) : vertices_of(rule.of, shared, select);
    shared.point_constraints.push_back(
        {rule.name, VertexCombination::mean_of(vertices), rule.kind, rule.direction});
    shared.through.push_back(rule.through);
  }
}

/// Collects chains of mesh edges, smooth or rigid.
void gather_lines(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                  SharedConstraints& shared) {
  for (const LineSpec& rule : scene.lines) {
    const std::vector<int> chain = select.path(rule);
    try {
      check_chain(rule.name, chain, rule.rigid);
    } catch (const InputError& e) {
      throw InputError(scene.at(rule.location) + e.what());
    }
    shared.lines.push_back(chain);
    if (rule.closed) shared.lines.back().push_back(chain.front());
    if (rule.rigid)
      shared.features.push_back({rule.name, chain, FormFeature::Kind::Free});
    else
      shared.chains.push_back(
          with_default_width({rule.name, chain, rule.closed, rule.width}, mesh));
  }
}

/// Fairs the curve of a [[curve]] and applies its loads.
MeshCurve shape_curve(const DeformScene& scene, const CurveSpec& rule, VertexSelector& select,
                      const TriangleMesh& mesh) {
  MeshCurve result{rule.line.name, select.path(rule.line), {}};
  std::vector<Vec3> points;
  for (const int v : result.vertices) points.push_back(mesh.point(v));
  const SculptedCurveOptions options{rule.line.closed, rule.faired, rule.fair, rule.ends,
                                     rule.alpha,       rule.beta,   rule.loads};
  try {
    if (!rule.file.empty())
      points =
          points_along(points, rule.line.closed,
                       read_curve_samples({rule.file, rule.curve.text, rule.unit, scene.unit}));
    result.shape = sculpt_curve(rule.line.name, points, options);
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(scene.at(rule.line.location) + "the curve '" + rule.line.name +
                          "': " + e.what());
  } catch (const InputError& e) {
    throw InputError(scene.at(rule.line.location) + e.what());
  }
  return result;
}

/// Collects deformable curves, each with the constraints that make the mesh follow it.
void gather_curves(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                   SharedConstraints& shared) {
  for (const CurveSpec& rule : scene.curves) {
    MeshCurve curve = shape_curve(scene, rule, select, mesh);
    shared.lines.push_back(curve.vertices);
    if (rule.line.closed) shared.lines.back().push_back(curve.vertices.front());
    const auto rows = position_constraints(curve.name, curve.vertices, curve.shape.targets);
    shared.rows.insert(shared.rows.end(), rows.begin(), rows.end());
    shared.curves.push_back(std::move(curve));
  }
}

/// Collects position constraints of single vertices.
void gather_soft_constraints(const DeformScene& scene, VertexSelector& select,
                             const TriangleMesh& mesh, SharedConstraints& shared) {
  for (const PositionConstraintSpec& rule : scene.position_constraints) {
    const int v = rule.node ? select.vertex_of_label(*rule.node, rule.location)
                            : nearest_vertex(mesh, *rule.at);
    shared.rows.push_back({rule.name, {{{v, 1.0}}}, rule.to, -1, rule.weight});
  }
}

/// Adds a note for features that share a vertex; these are merged.
void note_merged(SharedConstraints& shared, int vertices) {
  std::vector<int> owner(vertices, -1);
  std::set<std::pair<int, int>> pairs;
  for (int f = 0; f < isize(shared.features); ++f)
    for (const int v : shared.features[f].vertices) {
      if (owner[v] >= 0 && owner[v] != f) pairs.insert({owner[v], f});
      owner[v] = f;
    }
  for (const auto& [a, b] : pairs)
    shared.notes.push_back("the features '" + shared.features[a].name + "' and '" +
                           shared.features[b].name + "' share nodes and move as one rigid feature");
}

/// The reference point of a feature: the mean of its loop for a proposed hole, otherwise of its
/// vertices.
VertexCombination centre_of(const FormFeature& feature, VertexSelector& select,
                            const TriangleMesh& mesh) {
  const DetectedFeature* p = select.proposal(feature.name);
  return VertexCombination::mean_of(p ? mesh.topology().nodes_of(p->loop) : feature.vertices);
}

/// The relation of a scene, with its features as indices into `names`.
FeatureRelation relation_of(const DeformScene& scene, const RelationSpec& rule,
                            const std::vector<std::string>& names, VertexSelector& select) {
  FeatureRelation relation{rule.name, rule.kind, {}, {}, rule.plane};
  std::vector<int>& features = relation.features;
  for (const LocatedString& word : rule.of) {
    bool any = false;
    for (int f = 0; f < isize(names); ++f)
      if (matches_wildcard(word.text, names[f])) {
        any = true;
        if (std::find(features.begin(), features.end(), f) == features.end()) features.push_back(f);
      }
    if (!any)
      throw InputError(scene.at(word.location) + "found '" + word.text + "', expected a feature: " +
                       comma_separated(names) + did_you_mean(word.text, names));
  }
  if (rule.kind == RelationSpec::Kind::Coaxial && !features.empty())
    if (const DetectedFeature* hole = select.proposal(names[features[0]]))
      relation.hole = hole->measure;
  return relation;
}

/// Adds the constraints, guides and shared rotations of all relations.
void gather_relations(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                      SharedConstraints& shared) {
  std::vector<std::string> names;
  for (const auto& f : shared.features) names.push_back(f.name);
  const auto append = [](auto& to, const auto& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (const RelationSpec& rule : scene.relations) {
    const FeatureRelation relation = relation_of(scene, rule, names, select);
    try {
      const RelationConstraints added =
          relation_constraints(relation, shared.features, shared.centres, mesh.points());
      append(shared.shared_rotations, added.shared_rotations);
      append(shared.rows, added.rows);
      append(shared.point_constraints, added.point_constraints);
      append(shared.through, added.constraint_origins);
    } catch (const InputError& e) {
      throw InputError(scene.at(rule.location) + e.what());
    }
  }
}

HandleTransform handle_move(const EditSpec::MovedHandle& h, const std::vector<int>& vertices,
                            const TriangleMesh& mesh) {
  HandleTransform move;
  move.about = h.about ? *h.about : VertexCombination::mean_of(vertices).at(mesh.points());
  move.rotation_vector = to_rotation_vector(h.axis, h.degrees * std::numbers::pi / 180);
  move.translation = h.translate;
  move.scale = h.scale;
  return move;
}

/// The scales of all features. Also checks that the features of prescribed rotations exist.
std::vector<double> feature_scales(const DeformScene& scene, const EditSpec& rule,
                                   const SharedConstraints& shared, size_t features) {
  std::vector<std::string> names;
  for (const auto& f : shared.features) names.push_back(f.name);
  const auto require = [&](const LocatedString& word, const std::string& what) {
    if (std::none_of(names.begin(), names.end(),
                     [&](const auto& name) { return matches_wildcard(word.text, name); }))
      throw InputError(scene.at(word.location) + "found a " + what + " of '" + word.text +
                       "', expected a feature: " + comma_separated(names) +
                       did_you_mean(word.text, names));
  };
  std::vector<double> scales(features, 1.0);
  for (const auto& s : rule.scales) {
    require(s.feature, "scale");
    for (size_t f = 0; f < names.size(); ++f)
      if (matches_wildcard(s.feature.text, names[f])) scales[f] = s.factor;
  }
  for (const auto& t : rule.rotated_features) require(t.feature, "rotation");
  return scales;
}

/// A point of the plane or axis of each constraint.
std::vector<Vec3> guide_points(const DeformScene& scene, const EditSpec& rule,
                               const SharedConstraints& shared, const TriangleMesh& mesh) {
  std::vector<std::string> names;
  std::vector<Vec3> points;
  for (size_t k = 0; k < shared.point_constraints.size(); ++k) {
    names.push_back(shared.point_constraints[k].name);
    points.push_back(shared.through[k] ? *shared.through[k]
                                       : shared.point_constraints[k].point.at(mesh.points()));
  }
  for (const auto& g : rule.guides) {
    const auto it = std::find(names.begin(), names.end(), g.guide.text);
    if (it == names.end())
      throw InputError(scene.at(g.guide.location) + "found the constraint '" + g.guide.text +
                       "', expected " + expected_one_of(g.guide.text, names));
    points[it - names.begin()] = g.through;
  }
  return points;
}

}  // namespace

CharacterChain with_default_width(CharacterChain chain, const TriangleMesh& mesh) {
  check_chain(chain.name, chain.vertices, false);
  if (chain.width == 0) chain.width = chain_length(mesh, chain.vertices, chain.closed) / 10;
  return chain;
}

double distance_from(const MeshCurve& curve, const Points& p) {
  double worst = 0;
  for (const int v : curve.vertices)
    worst = std::max(worst, curve.shape.curve.closest_point(p.row(v).transpose()).distance);
  return worst;
}

SharedConstraints gather_shared_constraints(const DeformScene& scene, VertexSelector& select,
                                            const AttachedNodes& attached,
                                            const TriangleMesh& mesh) {
  SharedConstraints shared;
  shared.attached = &attached;
  shared.notes = attached.notes();
  gather_features(scene, select, shared);
  gather_guides(scene, select, mesh, shared);
  gather_lines(scene, select, mesh, shared);
  for (const FormFeature& f : shared.features) shared.centres.push_back(centre_of(f, select, mesh));
  gather_relations(scene, select, mesh, shared);
  note_merged(shared, mesh.vertex_count());
  gather_curves(scene, select, mesh, shared);
  gather_soft_constraints(scene, select, mesh, shared);
  return shared;
}

DeformEdit edit_of(const DeformScene& scene, const EditSpec& rule, const SharedConstraints& shared,
                   const DeformProblem& problem, const TriangleMesh& mesh) {
  DeformEdit edit;
  for (size_t i = 0; i < rule.handles.size(); ++i)
    edit.handles.push_back(handle_move(rule.handles[i], problem.handles[i].vertices, mesh));
  edit.feature_scales = feature_scales(scene, rule, shared, problem.features.size());
  edit.constraint_origins = guide_points(scene, rule, shared, mesh);
  return edit;
}

DeformTask make_deform_task(const DeformScene& scene, const EditSpec& rule,
                            const SharedConstraints& shared, VertexSelector& select,
                            const TriangleMesh& mesh) {
  DeformTask task;
  task.problem.fixed = select.of(rule.fixed);
  task.problem.features = shared.features;
  task.problem.shared_rotations = shared.shared_rotations;
  task.problem.point_constraints = shared.point_constraints;
  task.problem.chains = shared.chains;
  task.problem.rows = shared.rows;
  task.problem.weighting = scene.weighting;
  for (const auto& h : rule.handles)
    task.problem.handles.push_back({h.name, select.of(h.vertices)});
  if (!rule.region.empty()) task.problem.region = select.of(rule.region);
  shared.attached->add_to(task.problem, mesh.points());
  task.edit = edit_of(scene, rule, shared, task.problem, mesh);
  return task;
}

namespace {

/// The prescribed rotations of an edit, in the order of the scene.
std::vector<PrescribedRotation> prescribed_rotations(const EditSpec& rule,
                                                     const DeformProblem& problem) {
  std::vector<PrescribedRotation> prescribed;
  for (const auto& rotated : rule.rotated_features)
    for (int f = 0; f < isize(problem.features); ++f)
      if (matches_wildcard(rotated.feature.text, problem.features[f].name))
        prescribed.push_back(
            {f,
             Eigen::AngleAxisd(rotated.degrees * std::numbers::pi / 180, rotated.axis).matrix()});
  return prescribed;
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
                         const PreparedMesh& prepared, const Points& before, double tolerance)
    : scene_(scene),
      rule_(rule),
      shared_(shared),
      select_(select),
      prepared_(prepared),
      tolerance_(tolerance),
      followers_(shared.targets) {
  for (TargetFollower& follower : followers_) follower.find_vertices(before);
  DeformTask task = task_at(before);
  with_edit_context([&] { build(before, std::move(task)); });
}

/// The problem, with the springs of the followers.
DeformTask EditSession::task_at(const Points& before) {
  SharedConstraints shared = shared_;
  for (size_t k = 0; k < followers_.size(); ++k) {
    const auto springs = followers_[k].springs("target " + std::to_string(k + 1), scene_.weighting);
    shared.rows.insert(shared.rows.end(), springs.begin(), springs.end());
  }
  DeformTask task =
      make_deform_task(scene_, rule_, shared, select_, prepared_.mesh.with_points(before));
  spring_ends_.clear();
  tie_targets_.clear();
  for (size_t r = shared_.rows.size(); r < task.problem.rows.size(); ++r)
    (r < shared.rows.size() ? spring_ends_ : tie_targets_).push_back(task.problem.rows[r].target);
  return task;
}

/// Factors the problem.
void EditSession::build(const Points& before, DeformTask task) {
  const MeshEditorOptions options{rule_.rotation_mode, rule_.keep_centres, shared_.centres,
                                  tolerance_};
  editor_ = std::make_unique<MeshEditor>(prepared_, before, std::move(task.problem), options,
                                         shared_.attached);
  editor_->set(current_edit(), prescribed_rotations(rule_, editor_->problem()));
}

DeformEdit EditSession::current_edit() const {
  DeformEdit edit = edit_of(scene_, rule_, shared_, editor_->problem(), editor_->mesh());
  for (const LinearConstraint& row : shared_.rows) edit.targets.push_back(row.target);
  edit.targets.insert(edit.targets.end(), spring_ends_.begin(), spring_ends_.end());
  edit.targets.insert(edit.targets.end(), tie_targets_.begin(), tie_targets_.end());
  return edit;
}

void EditSession::set(const EditSpec& rule) {
  const EditSpec before = std::exchange(rule_, rule);
  try {
    editor_->set(current_edit(), prescribed_rotations(rule, editor_->problem()));
  } catch (...) {
    rule_ = before;
    throw;
  }
}

const Points& EditSession::solve_preview() {
  with_edit_context([&] { editor_->solve_preview(); });
  return editor_->shape();
}

const Points& EditSession::solve_to_equilibrium() {
  with_edit_context([&] {
    if (!followers_.empty()) follow_targets();
    editor_->solve_to_equilibrium();
  });
  return editor_->shape();
}

/// The ends of all springs for a shape.
void EditSession::move_springs(const Points& shape) {
  spring_ends_.clear();
  for (const TargetFollower& follower : followers_) {
    const auto ends = follower.closest_points(shape);
    spring_ends_.insert(spring_ends_.end(), ends.begin(), ends.end());
  }
}

/// The shape of the mesh without features that follows the targets: the springs are moved to the
/// closest points until the shape rests.
Points EditSession::shape_on_targets() {
  constexpr int most_iterations = 30;
  double rest = followers_.front().options().smoothing;  // a small part of an element, by default
  for (const TargetFollower& follower : followers_)
    rest = std::min(rest, follower.options().smoothing);
  rest *= 5e-4;
  const Points& before = editor_->mesh().points();
  DeformProblem problem = editor_->problem();
  const auto own = static_cast<long>(shared_.features.size());
  problem.features.erase(problem.features.begin(), problem.features.begin() + own);
  problem.shared_rotations.clear();
  problem.rows.resize(shared_.rows.size() + spring_ends_.size() + tie_targets_.size());
  problem.bending = DeformProblem::Bending::Hinges;
  if (!plain_)
    plain_ = std::make_unique<MeshEditor>(prepared_, before, std::move(problem),
                                          MeshEditorOptions{RotationMode::Harmonic, false, {}, 0});
  // Iterated Tikhonov regularization: each stage preserves the curvature that the previous one found.
  // All but the last one may be less accurate.
  constexpr int stages = 3;
  constexpr double coarse = 4;
  Points shape = before;
  plain_->set_estimate(std::nullopt);
  for (int stage = 0; stage < stages; ++stage) {
    if (stage > 0) plain_->set_estimate(shape);
    const double enough = stage + 1 < stages ? coarse * rest : rest;
    double change = std::numeric_limits<double>::infinity();
    for (int k = 0; k < most_iterations && change > enough; ++k) {
      move_springs(shape);
      DeformEdit edit = current_edit();
      edit.feature_scales.clear();
      plain_->set(std::move(edit));
      const Points& next = plain_->solve_preview();
      change = (next - shape).cwiseAbs().maxCoeff();
      shape = next;
    }
  }
  return shape;
}

/// Attaches the springs of the edit to the targets. The vertices with springs are determined again in
/// the shape on the targets.
void EditSession::follow_targets() {
  constexpr int most_rounds = 6;
  for (int round = 0; round < most_rounds; ++round) {
    Points shape = shape_on_targets();
    bool others = false;
    for (TargetFollower& follower : followers_) others = follower.find_vertices(shape) || others;
    if (!others || round + 1 == most_rounds) {
      move_springs(shape);
      editor_->set_estimate(std::move(shape));
      editor_->set(current_edit(), prescribed_rotations(rule_, editor_->problem()));
      return;
    }
    const Points before = editor_->mesh().points();
    plain_.reset();
    build(before, task_at(before));
  }
}

}  // namespace batten
