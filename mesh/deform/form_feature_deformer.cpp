// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/form_feature_deformer.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/feature_moments.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {

FormFeatureDeformer::FormFeatureDeformer(const TriangleMesh& mesh, DeformProblem problem)
    : data_(std::make_unique<FormFeatureData>(mesh, std::move(problem))) {}
FormFeatureDeformer::~FormFeatureDeformer() = default;
FormFeatureDeformer::FormFeatureDeformer(FormFeatureDeformer&&) noexcept = default;
FormFeatureDeformer& FormFeatureDeformer::operator=(FormFeatureDeformer&&) noexcept = default;

const Points& FormFeatureDeformer::deform(const DeformEdit& edit) {
  FormFeatureData& d = *data_;
  check(d.problem, edit);
  d.can_correct = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.set_hard_values(edit);
  d.set_point_constraints(edit);
  d.set_targets(edit, nullptr);
  d.is_estimated = false;
  return d.solve(edit);
}

const Points& FormFeatureDeformer::deform(const DeformEdit& edit, const ShapeEstimate& estimate) {
  FormFeatureData& d = *data_;
  check(d.problem, edit);
  d.check_estimate(estimate);
  d.can_correct = false;
  d.rotations.evaluate(d.system, edit, d.q);
  d.apply_estimated_rotations(estimate);
  d.set_hard_values(edit);
  d.set_point_constraints(edit);
  d.set_targets(edit, &estimate);
  d.is_estimated = true;
  return d.solve(edit);
}

double FormFeatureDeformer::correct() {
  FormFeatureData& d = *data_;
  if (!d.can_correct) throw InputError("correct() without an edit: call deform() first");
  if (d.positions.free_count() == 0 || d.size == 0) return 0;
  // Residual b - A x, computed with the accuracy of the original rows.
  d.start_residual();
  for (long c = 0; c < d.B.cols(); ++c)
    for (SparseMatrix::InnerIterator e(d.B, c); e; ++e)
      d.r.row(e.row()) -= e.value() * (d.y.row(c) - d.y_rest.row(c));
  d.reduce_residual();
  d.factor.solve_in_place(d.load);
  d.y += d.load;
  d.apply_point_constraints();
  const Points before = d.result;
  d.expand(d.last);
  return (d.result - before).cwiseAbs().maxCoeff() / d.size;
}

FeatureMoments& FormFeatureDeformer::moments() {
  if (!moments_) moments_ = std::make_unique<FeatureMoments>(*data_);
  return *moments_;
}

const Points& FormFeatureDeformer::feature_moments() {
  FormFeatureData& d = *data_;
  if (!d.can_correct) throw InputError("moments without an edit: call deform() first");
  return moments().evaluate(d);
}

FeatureStiffness FormFeatureDeformer::feature_stiffness(std::span<const int> body) {
  FormFeatureData& d = *data_;
  if (!d.can_correct || !d.is_estimated)
    throw InputError(
        "stiffness of features without rotations: call deform() with an estimate first");
  if (body.size() != d.problem.features.size())
    throw InputError("found " + std::to_string(body.size()) + " bodies of features, expected " +
                     std::to_string(d.problem.features.size()));
  return moments().stiffness(d, body);
}

const Points& FormFeatureDeformer::positions() const { return data_->result; }
const TriangleMesh& FormFeatureDeformer::mesh() const { return data_->mesh; }
const DeformProblem& FormFeatureDeformer::problem() const { return data_->problem; }
const std::vector<std::string>& FormFeatureDeformer::notes() const { return data_->system.notes; }

Points FormFeatureDeformer::rotation_logs() const {
  const FormFeatureData& d = *data_;
  Points q = Points::Zero(d.mesh.vertex_count(), 3);
  for (int v = 0; v < d.mesh.vertex_count(); ++v)
    if (const int dof = d.system.dof[v]; dof >= 0)
      q.row(v) = d.last_valid_q.row(dof);
    else if (const int h = d.system.constrained_by[v]; h >= 0 && d.solved)
      q.row(v) = d.last.handles[h].rotation_vector;
  return q;
}

double FormFeatureDeformer::hard_residual() const {
  const FormFeatureData& d = *data_;
  return d.solved ? batten::hard_residual(d.mesh, d.problem, d.last, d.result, rotation_logs()) : 0;
}

FormFeatureDeformer::Counts FormFeatureDeformer::counts() const {
  const FormFeatureData& d = *data_;
  Counts c;
  c.moving = d.system.moving;
  c.unknowns = d.positions.free_count();
  c.soft_equations = static_cast<int>(d.system.A.rows());
  c.hard_constraints = isize(d.system.values);
  c.feature_constraints = d.system.feature_constraints;
  c.redundant_count = d.positions.redundant_count();
  c.point_equations = isize(d.constraint_of_equation);
  c.factor_entries = d.positions.free_count() > 0 ? d.factor.factor_entries() : 0;
  return c;
}

FormFeatureDeformer::ProblemMatrices FormFeatureDeformer::problem_matrices(const DeformEdit& edit) {
  deform(edit);
  const FormFeatureData& d = *data_;
  ProblemMatrices s{d.system.vertex, d.system.origin, d.system.A, d.b,
                    ConstraintSet(isize(d.system.vertex))};
  const auto& rows = d.system.positions.constraints();
  std::vector<char> implied(rows.size(), 0);
  for (const int k : d.positions.redundant()) implied[k] = 1;
  for (size_t k = 0; k < rows.size(); ++k)
    if (!implied[k])
      s.constraints.add(d.system.positions.names()[rows[k].name], rows[k].entries,
                        d.rhs.row(static_cast<long>(k)).transpose());
  for (const int k : d.coupling.independent())
    d.add_point_equation(s.constraints, static_cast<size_t>(k),
                         d.equation_directions[k].dot(d.constraint_origin(edit, k)));
  return s;
}

// Constraint violation, evaluated independently of the deformer's own rows.

double hard_residual(const TriangleMesh& mesh, const DeformProblem& problem, const DeformEdit& edit,
                     const Points& p, const Points& logs) {
  double worst = 0;
  const auto accumulate = [&](double off) {
    // NaN counts as the worst value.
    if (!std::isnan(worst) && !(off <= worst)) worst = off;
  };
  const auto point = [&](int v) { return Vec3(p.row(v).transpose()); };
  std::vector<char> may_move(mesh.vertex_count(), problem.region ? 0 : 1);
  if (problem.region)
    for (const int v : *problem.region) may_move[v] = 1;
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices) {
      may_move[v] = 1;
      accumulate((point(v) - edit.handles[h](mesh.point(v))).norm());
    }
  for (const int v : problem.fixed) may_move[v] = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!may_move[v]) accumulate((point(v) - mesh.point(v)).norm());

  for (size_t f = 0; f < problem.features.size(); ++f) {
    const double scale = edit.feature_scales.empty() ? 1 : edit.feature_scales[f];
    const auto& feature = problem.features[f];
    const Similarity fit = fit_similarity(mesh.points(), p, feature.vertices, scale);
    const Vec3 first = mesh.point(feature.vertices[0]);
    for (const int v : feature.vertices) {
      accumulate((fit.scale * (fit.R * mesh.point(v)) + fit.translation - point(v)).norm());
      if (feature.kind == FormFeature::Kind::TranslationOnly)
        accumulate(
            (scale * (mesh.point(v) - first) - (point(v) - point(feature.vertices[0]))).norm());
    }
  }
  for (size_t k = 0; k < problem.point_constraints.size(); ++k) {
    const PointConstraint& constraint = problem.point_constraints[k];
    const Vec3 constraint_origin = edit.constraint_origins.empty()
                                       ? constraint.point.at(mesh.points())
                                       : edit.constraint_origins[k];
    const Vec3 off = constraint.point.at(p) - constraint_origin,
               n = constraint.direction.normalized();
    accumulate(constraint.kind == PointConstraint::Kind::OnPlane ? std::abs(n.dot(off))
                                                                 : n.cross(off).norm());
  }
  for (size_t k = 0; k < problem.rows.size(); ++k) {
    const LinearConstraint& row = problem.rows[k];
    if (row.weight) continue;
    Vec3 target = edit.targets.empty() ? row.target : edit.targets[k];
    if (row.rotates_with >= 0) target = rotated(logs.row(row.rotates_with).transpose(), target);
    accumulate((row.combination.at(p) - target).norm());
  }
  const double size = mesh.size();
  return size > 0 ? worst / size : worst;
}

}  // namespace batten
