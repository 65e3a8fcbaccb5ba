#include "batten/apps/commands/meshes/deform_task.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "batten/apps/commands/meshes/vertex_selector.h"
#include "batten/apps/commands/runs/run_support.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/mesh/selection.h"

namespace batten {

// Relations between features of a deform scene, as linear constraints and shared rotations.

/// The reference point of a feature: the mean of its loop for a proposed hole, otherwise of its
/// vertices.
VertexCombination centre_of(const FormFeature& feature, VertexSelector& select,
                            const TriangleMesh& mesh);

/// Adds the constraints, guides and shared rotations of all [[relation]]s. Throws InputError, with
/// the location, for unknown or too few features, and for features that do not satisfy the relation
/// initially (different axes, uneven spacing, no mirror images).
void gather_relations(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                      SharedConstraints& shared);

namespace {

ConstraintSet end_constraints(const HermiteCurve& curve, CurveSpec::Ends ends) {
  ConstraintSet set(curve.mesh().dof_count());
  if (curve.closed() || ends == CurveSpec::Ends::Free) return set;
  CurveConstraints rows(curve.mesh(), set);
  for (const double u : {curve.start(), curve.end()}) {
    rows.point("ends", u, curve.evaluate(u));
    if (ends == CurveSpec::Ends::Clamped) rows.derivative("ends", u, curve.evaluate(u, 1));
  }
  return set;
}

double chain_length(const TriangleMesh& mesh, const std::vector<int>& chain, bool closed) {
  double sum = 0;
  for (size_t i = 0; i + 1 < chain.size() + (closed ? 1 : 0); ++i)
    sum += (mesh.point(chain[(i + 1) % chain.size()]) - mesh.point(chain[i])).norm();
  return sum;
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
    if (const DetectedFeature* p = select.proposal(rule.of.text)) {
      vertices = mesh.topology().nodes_of(p->loop);
    } else {
      const auto feature = std::find_if(shared.features.begin(), shared.features.end(),
                                        [&](const auto& f) { return f.name == rule.of.text; });
      vertices = feature != shared.features.end() ? feature->vertices : select.of(rule.of);
    }
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
    const size_t different = std::set<int>(chain.begin(), chain.end()).size();
    if (different < 3 || (!rule.rigid && different < chain.size()))
      throw InputError(scene.at(rule.location) + "the chain '" + rule.name + "': found " +
                       std::to_string(chain.size()) + " nodes, " + std::to_string(different) +
                       " of them different, expected at least three, each once");
    shared.lines.push_back(chain);
    if (rule.closed) shared.lines.back().push_back(chain.front());
    if (rule.rigid) {
      shared.features.push_back({rule.name, chain, FormFeature::Kind::Free});
      continue;
    }
    const double width = rule.width > 0 ? rule.width : chain_length(mesh, chain, rule.closed) / 10;
    shared.chains.push_back({rule.name, chain, rule.closed, width});
  }
}

/// Collects deformable curves, each with the constraints that make the mesh follow it.
void gather_curves(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                   SharedConstraints& shared) {
  for (const CurveSpec& rule : scene.curves) {
    MeshCurve curve = shape_curve(scene, rule, select, mesh);
    shared.lines.push_back(curve.vertices);
    if (rule.line.closed) shared.lines.back().push_back(curve.vertices.front());
    for (size_t i = 0; i < curve.vertices.size(); ++i)
      shared.rows.push_back({curve.name + ", vertex " + std::to_string(i + 1),
                             {{{curve.vertices[i], 1.0}}},
                             curve.targets[i],
                             -1,
                             std::nullopt});
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

MeshCurve shape_curve(const DeformScene& scene, const CurveSpec& rule, VertexSelector& select,
                      const TriangleMesh& mesh) {
  MeshCurve result;
  result.name = rule.line.name;
  result.vertices = select.path(rule.line);
  std::vector<Vec3> points;
  for (const int v : result.vertices) points.push_back(mesh.point(v));
  FairOptions options = rule.fair;
  options.reject_outliers = false;  // vertices of a mesh are no outliers
  options.closed = rule.line.closed;
  options.fix_ends = !rule.line.closed;
  try {
    const HermiteCurve given = interpolating_spline(rule.line.name, points, options);
    if (!rule.faired) {
      options.smoothing = FairOptions::Smoothing::Wavelength;
      options.wavelength = 1e-6 * given.length();  // interpolates the vertices
    }
    const FairCurve fair = fair_points(rule.line.name, points, options);
    result.fairing = fair.deviation;
    result.wavelength = fair.wavelength;
    result.before = fairness(given);
    result.curve = fair.curve;
    if (!rule.loads.empty()) {
      CurveMaterial material;
      material.alpha = {rule.alpha};
      material.beta = {rule.beta};
      DeformableCurve deformable(fair.curve, end_constraints(fair.curve, rule.ends), material,
                                 rule.loads);
      result.curve = deformable.solve();
    }
    for (const double u : fair.parameters) {
      result.targets.push_back(result.curve.evaluate(u));
      result.largest_shift =
          std::max(result.largest_shift, (result.targets.back() - fair.curve.evaluate(u)).norm());
    }
  } catch (const NoSolutionError& e) {
    throw NoSolutionError(scene.at(rule.line.location) + "the curve '" + rule.line.name +
                          "': " + e.what());
  } catch (const InputError& e) {
    throw InputError(scene.at(rule.line.location) + e.what());
  }
  result.after = fairness(result.curve);
  return result;
}

double distance_from(const MeshCurve& curve, const Points& p) {
  double worst = 0;
  for (const int v : curve.vertices)
    worst = std::max(worst, curve.curve.closest_point(p.row(v).transpose()).distance);
  return worst;
}

SharedConstraints gather_shared_constraints(const DeformScene& scene, VertexSelector& select,
                                            const AttachedNodes& attached,
                                            const TriangleMesh& mesh) {
  SharedConstraints shared;
  shared.attached = &attached;
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

DeformTask with_fixed_centres(DeformTask task, const SharedConstraints& shared,
                              const Points& unscaled) {
  for (size_t f = 0; f < shared.features.size(); ++f) {
    task.problem.rows.push_back({"centre of " + shared.features[f].name, shared.centres[f],
                                 shared.centres[f].at(unscaled), -1, std::nullopt});
    if (!task.edit.targets.empty()) task.edit.targets.push_back(task.problem.rows.back().target);
  }
  return task;
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
  const std::vector<FormFeature>& connections = shared.attached->connections();
  task.problem.features = shared.features;
  task.problem.features.insert(task.problem.features.end(), connections.begin(), connections.end());
  task.problem.shared_rotations = shared.shared_rotations;
  task.problem.point_constraints = shared.point_constraints;
  task.problem.chains = shared.chains;
  task.problem.rows = shared.rows;
  task.problem.weighting = scene.weighting;
  for (const auto& h : rule.handles)
    task.problem.handles.push_back({h.name, select.of(h.vertices)});
  if (!rule.region.empty()) {
    task.problem.region = select.of(rule.region);
    shared.attached->extend_region(*task.problem.region, task.problem.handles);
  }
  task.edit = edit_of(scene, rule, shared, task.problem, mesh);
  return task;
}

namespace {

using Kind = RelationSpec::Kind;

/// Tolerance of relations in the initial shape, relative to the distance of the centres.
constexpr double kNear = 1e-3;

void add_to(VertexCombination& sum, const VertexCombination& point, double factor) {
  for (const auto& e : point.entries) sum.entries.push_back({e.vertex, factor * e.coefficient});
}

class Relation {
 public:
  Relation(const DeformScene& scene, const RelationSpec& rule, VertexSelector& select,
           const TriangleMesh& mesh, SharedConstraints& shared)
      : scene_(scene), rule_(rule), select_(select), mesh_(mesh), shared_(shared) {
    find_features();
  }

  void add() {
    if (rule_.kind == Kind::Parallel || rule_.kind == Kind::Coaxial)
      shared_.shared_rotations.push_back(features_);
    if (rule_.kind == Kind::Coaxial) expect_one_axis();
    if (rule_.kind == Kind::Coaxial || rule_.kind == Kind::Distance) keep_differences();
    if (rule_.kind == Kind::Spacing) keep_steps();
    if (rule_.kind == Kind::Symmetric) keep_mirror_images();
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(scene_.at(rule_.location) + "the relation '" + rule_.name + "': found " +
                     found + ", expected " + expected);
  }

  const std::string& name(size_t i) const { return shared_.features[features_[i]].name; }
  Vec3 at(size_t i) const { return centres_[i].at(mesh_.points()); }

  void find_features() {
    std::vector<std::string> names;
    for (const auto& f : shared_.features) names.push_back(f.name);
    for (const LocatedString& word : rule_.of) {
      bool any = false;
      for (int f = 0; f < isize(names); ++f)
        if (matches_wildcard(word.text, names[f])) {
          any = true;
          if (std::find(features_.begin(), features_.end(), f) == features_.end())
            features_.push_back(f);
        }
      if (!any)
        throw InputError(scene_.at(word.location) + "found '" + word.text +
                         "', expected a feature: " + comma_separated(names) +
                         did_you_mean(word.text, names));
    }
    const size_t least = rule_.kind == Kind::Spacing ? 3 : 2;
    if (features_.size() < least || (rule_.kind == Kind::Symmetric && features_.size() > 2))
      fail(std::to_string(features_.size()) + " features",
           rule_.kind == Kind::Symmetric ? "two" : std::to_string(least) + " or more");
    for (const int f : features_) centres_.push_back(shared_.centres[f]);
  }

  /// Checks that holes have a common axis; only holes have a known axis.
  void expect_one_axis() const {
    for (size_t i = 1; i < features_.size(); ++i) {
      const DetectedFeature* hole = select_.proposal(name(0));
      if (!hole) return;
      const Vec3 apart = at(i) - at(0);
      const double off = hole->measure.axis.cross(apart).norm();
      if (off > kNear * std::max(apart.norm(), hole->measure.radius))
        fail("the centre of '" + name(i) + "' at a distance of " + format_number(off) +
                 " from the axis of '" + name(0) + "'",
             "centres on a common axis; type = \"distance\" keeps the centres at their distance");
    }
  }

  void add_row(size_t i, VertexCombination combination) {
    LinearConstraint row;
    row.name = rule_.name + ", " + name(i);
    row.target = combination.at(mesh_.points());
    row.combination = std::move(combination);
    row.rotates_with = shared_.features[features_[0]].vertices[0];
    shared_.rows.push_back(std::move(row));
  }

  void keep_differences() {
    for (size_t i = 1; i < features_.size(); ++i) {
      VertexCombination apart = centres_[i];
      add_to(apart, centres_[0], -1);
      add_row(i, std::move(apart));
    }
  }

  void keep_steps() {
    for (size_t i = 1; i + 1 < features_.size(); ++i) {
      const Vec3 before = at(i) - at(i - 1), after = at(i + 1) - at(i);
      if ((after - before).norm() > kNear * before.norm())
        fail("spacings of " + format_number(before.norm()) + " and " + format_number(after.norm()) +
                 " before and after '" + name(i) + "'",
             "equal spacings on a straight line, with the features in their order");
      VertexCombination change = centres_[i + 1];
      add_to(change, centres_[i], -2);
      add_to(change, centres_[i - 1], 1);
      add_row(i, std::move(change));
    }
  }

  void keep_mirror_images() {
    const Vec3 normal = rule_.plane->first.normalized(), apart = at(1) - at(0);
    const double off = std::max(normal.cross(apart).norm(),
                                std::abs(normal.dot((at(0) + at(1)) / 2 - rule_.plane->second)));
    if (off > kNear * apart.norm())
      fail("centres that deviate by " + format_number(off) + " from mirror images",
           "centres that are mirror images in the plane");
    VertexCombination middle, vector = centres_[1];
    add_to(middle, centres_[0], 0.5);
    add_to(middle, centres_[1], 0.5);
    add_to(vector, centres_[0], -1);
    shared_.point_constraints.push_back(
        {rule_.name + ", middle", std::move(middle), PointConstraint::Kind::OnPlane, normal});
    shared_.through.push_back(rule_.plane->second);
    shared_.point_constraints.push_back(
        {rule_.name + ", across", std::move(vector), PointConstraint::Kind::OnLine, normal});
    shared_.through.push_back(Vec3(Vec3::Zero()));
  }

  const DeformScene& scene_;
  const RelationSpec& rule_;
  VertexSelector& select_;
  const TriangleMesh& mesh_;
  SharedConstraints& shared_;
  std::vector<int> features_;
  std::vector<VertexCombination> centres_;
};

}  // namespace

VertexCombination centre_of(const FormFeature& feature, VertexSelector& select,
                            const TriangleMesh& mesh) {
  const DetectedFeature* p = select.proposal(feature.name);
  return VertexCombination::mean_of(p ? mesh.topology().nodes_of(p->loop) : feature.vertices);
}

void gather_relations(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                      SharedConstraints& shared) {
  for (const RelationSpec& rule : scene.relations)
    Relation(scene, rule, select, mesh, shared).add();
}

}  // namespace batten
