// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/editing/mesh_editor.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

using Clock = std::chrono::steady_clock;
/// Rotations have converged if they change by less, in degrees; features then move by less than a
/// thousandth of their size.
constexpr double kConvergedDegrees = 0.05;
/// The iteration goes on to this change, so that the result is a smooth function of the edit.
constexpr double kExactDegrees = 1e-9;

double elapsed_seconds(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

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

/// True if the positions of the mesh satisfy an edit without any motion.
bool moves_nothing(const DeformProblem& problem, const DeformEdit& edit,
                   const std::vector<PrescribedRotation>& prescribed, const Points& points) {
  if (scales_features(edit)) return false;
  for (const HandleTransform& h : edit.handles)
    if (!h.rotation_vector.isZero(0) || !h.translation.isZero(0) || h.scale != 1) return false;
  for (const PrescribedRotation& p : prescribed)
    if (p.rotation != Mat3::Identity()) return false;
  const double rounding =
      16 * std::numeric_limits<double>::epsilon() * points.cwiseAbs().maxCoeff();
  for (size_t k = 0; k < edit.constraint_origins.size(); ++k) {
    const PointConstraint& c = problem.point_constraints[k];
    const Vec3 off = c.point.at(points) - edit.constraint_origins[k], n = c.direction.normalized();
    const double distance = c.kind == PointConstraint::Kind::OnPlane
                                ? std::abs(off.dot(n))
                                : Vec3(off - off.dot(n) * n).norm();
    if (!(distance <= rounding)) return false;
  }
  for (size_t r = 0; r < problem.rows.size(); ++r) {
    const Vec3& target = edit.targets.empty() ? problem.rows[r].target : edit.targets[r];
    if (!((problem.rows[r].combination.at(points) - target).cwiseAbs().maxCoeff() <= rounding))
      return false;
  }
  return true;
}

}  // namespace

MeshEditor::MeshEditor(const PreparedMesh& prepared, const Points& before, DeformProblem problem,
                       MeshEditorOptions options, const AttachedNodes* attached)
    : mesh_(prepared.mesh.with_points(before)),
      attached_(attached),
      options_(std::move(options)),
      problem_(std::move(problem)),
      own_features_(isize(problem_.features) - (attached ? isize(attached->connections()) : 0)),
      own_rows_(problem_.rows.size()),
      rotations_(prepared, mesh_, problem_, options_.rotation_mode, options_.tolerance),
      shape_(before) {
  if (options_.centres.empty())
    for (int f = 0; f < own_features_; ++f)
      options_.centres.push_back(VertexCombination::mean_of(problem_.features[f].vertices));
  if (isize(options_.centres) != own_features_)
    throw InputError("found " + std::to_string(options_.centres.size()) +
                     " centres of features, expected " + std::to_string(own_features_));
  set_up();
}

MeshEditor::~MeshEditor() = default;

// Without constraints on feature centres: these need a solved shape first.
void MeshEditor::set_up() {
  const auto start = Clock::now();
  equilibrium_.reset();
  live_.reset();
  deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, problem_);
  centres_kept_ = false;
  setup_seconds_ += elapsed_seconds(start);
}

void MeshEditor::set(DeformEdit edit, std::vector<PrescribedRotation> prescribed) {
  if (edit.feature_scales != edit_.feature_scales) equilibrium_.reset();
  if (equilibrium_) equilibrium_->reset();
  edit_ = std::move(edit);
  prescribed_ = std::move(prescribed);
  if (!centres_kept_) return;
  problem_.rows.erase(problem_.rows.begin() + static_cast<long>(own_rows_), problem_.rows.end());
  set_up();
}

/// Per feature: 1 if a relation, a point constraint or a linear constraint uses its vertices.
std::vector<char> MeshEditor::related_features() const {
  std::vector<int> owner(mesh_.vertex_count(), -1);
  for (int f = 0; f < own_features_; ++f)
    for (const int v : problem_.features[f].vertices) owner[v] = f;
  std::vector<char> related(static_cast<size_t>(own_features_), 0);
  const auto mark = [&](const VertexCombination& combination) {
    for (const auto& e : combination.entries)
      if (owner[e.vertex] >= 0) related[owner[e.vertex]] = 1;
  };
  for (const PointConstraint& c : problem_.point_constraints) mark(c.point);
  for (const LinearConstraint& row : problem_.rows) mark(row.combination);
  return related;
}

/// Fixes the centres of all features at `unscaled`, the positions without any feature scaling.
/// Features with relations are held by stiff springs: their rotations, and with them the relations,
/// may differ slightly with and without scaling.
void MeshEditor::fix_centres(const Points& unscaled) {
  DeformProblem fixed = problem_;
  DeformEdit edit = edit_;
  double area = 0;
  for (int t = 0; t < mesh_.triangle_count(); ++t) area += mesh_.area_vector(t).norm() / 2;
  area /= mesh_.triangle_count();
  constexpr double kStiffness = 1e6;  // relative to the curvature equations
  const double weight =
      kStiffness / (fixed.weighting == DeformProblem::Weighting::Area ? area : area * area);
  const std::vector<char> related = related_features();
  for (int f = 0; f < own_features_; ++f) {
    const VertexCombination& centre = options_.centres[f];
    fixed.rows.push_back({"centre of " + fixed.features[f].name, centre, centre.at(unscaled), -1,
                          related[f] ? std::optional(weight) : std::nullopt});
    if (!edit.targets.empty()) edit.targets.push_back(fixed.rows.back().target);
  }
  equilibrium_.reset();
  deformer_ = std::make_unique<FormFeatureDeformer>(mesh_, fixed);
  problem_ = std::move(fixed);
  edit_ = std::move(edit);
  centres_kept_ = true;
}

std::optional<ShapeEstimate> MeshEditor::estimate() {
  if (given_) return rotations_.estimate_from(*given_, edit_, prescribed_);
  return rotations_.estimate(edit_, prescribed_,
                             !moves_nothing(problem_, edit_, prescribed_, mesh_.points()));
}

const Points& MeshEditor::solve_preview() {
  at_rest_ = true;
  try {
    if (live_ && !given_ && options_.rotation_mode == RotationMode::Estimated)
      at_rest_ = update_rotations(*live_) < kConvergedDegrees;
    else
      live_ = estimate();
    shape_ = live_ ? deformer_->deform(edit_, *live_) : deformer_->deform(edit_);
  } catch (...) {
    live_.reset();  // it belongs to no solution
    throw;
  }
  return shape_;
}

// One step towards the equilibrium of the features. Returns the change of a rotation in degrees.
double MeshEditor::update_rotations(ShapeEstimate& estimate) {
  std::vector<int> body = rotations_.bodies(prescribed_, own_features_, estimate);
  if (!equilibrium_ || equilibrium_->body() != body)
    equilibrium_ = std::make_unique<FeatureEquilibrium>(*deformer_, std::move(body));
  return equilibrium_->rotate_features(*deformer_, estimate);
}

const Points& MeshEditor::solve_to_equilibrium() {
  statistics_ = {};
  live_.reset();
  check(problem_, edit_);
  if (moves_nothing(problem_, edit_, prescribed_, mesh_.points())) {
    statistics_.counts = deformer_->counts();
    statistics_.setup_seconds = setup_seconds_;
    shape_ = mesh_.points();
    return shape_;
  }
  auto start = Clock::now();
  std::optional<ShapeEstimate> estimate = this->estimate();
  statistics_.iterations = rotations_.iterations();
  statistics_.converged = rotations_.converged();
  statistics_.setup_seconds = setup_seconds_ + elapsed_seconds(start);
  start = Clock::now();
  if (!centres_kept_ && options_.keep_centres && scales_features(edit_)) {
    DeformEdit unscaled = edit_;
    unscaled.feature_scales.clear();
    converge_rotations(unscaled, estimate);
    fix_centres(deformer_->positions());
  }
  converge_rotations(edit_, estimate);
  statistics_.edit_seconds = elapsed_seconds(start);
  statistics_.last_correction = deformer_->correct();
  statistics_.counts = deformer_->counts();
  statistics_.hard_residual = deformer_->hard_residual();
  const Points &before = mesh_.points(), &found = deformer_->positions();
  statistics_.largest_displacement = (found - before).rowwise().norm().maxCoeff();
  shape_ = restore_unmoved(before, found);
  if (attached_) attached_->propagate(before, shape_, problem_);
  live_ = std::move(estimate);  // previews continue from here
  return shape_;
}

// Iterates, because the moments on features are not linear in their rotations.
void MeshEditor::converge_rotations(const DeformEdit& edit,
                                    std::optional<ShapeEstimate>& estimate) {
  estimate ? deformer_->deform(edit, *estimate) : deformer_->deform(edit);
  if (estimate && !given_ && options_.rotation_mode == RotationMode::Estimated &&
      own_features_ > 0) {
    constexpr int max_iterations = 100;
    if (equilibrium_) equilibrium_->reset();  // the result does not depend on earlier solutions
    double change = 2 * kConvergedDegrees;
    for (statistics_.iterations = 1;
         statistics_.iterations < max_iterations && change > kExactDegrees;
         ++statistics_.iterations) {
      change = update_rotations(*estimate);
      deformer_->deform(edit, *estimate);
    }
    statistics_.converged = change < kConvergedDegrees;
  }
  deformer_->correct();
}

}  // namespace batten
