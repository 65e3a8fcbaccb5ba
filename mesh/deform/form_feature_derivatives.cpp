// SPDX-License-Identifier: MPL-2.0
// Derivatives of FormFeatureDeformer. The solution is linear in the right-hand sides; these are
// products of scales, rotations and given vectors.
#include <cmath>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/mesh/deform/form_feature_data.h"
#include "batten/mesh/deform/form_feature_deformer.h"

namespace batten {
namespace {

/// Derivatives of the right-hand sides of the last solution, in either direction.
class EditDerivatives {
 public:
  explicit EditDerivatives(FormFeatureData& data)
      : d_(data), features_(isize(d_.problem.features)) {}

  Points tangent(const DeformEditRates& rates) {
    MatX rotation_rates = MatX::Zero(isize(d_.problem.handles), 3);
    for (long h = 0; h < rotation_rates.rows(); ++h)
      rotation_rates.row(h) = rates.handles[h].rotation_vector.transpose();
    const Points dq = d_.rotations.rates(rotation_rates);
    MatX rhs = MatX::Zero(d_.rhs.rows(), 3);
    for (long k = 0; k < rhs.rows(); ++k) rhs.row(k) = value_rate(k, rates, dq).transpose();
    const MatX d0 = d_.positions.rhs_to_particular() * rhs;
    RowPoints b(d_.b.rows(), 3);
    for (long i = 0; i < b.rows(); ++i) b.row(i) = target_rate(i, rates, dq).transpose();
    b -= d_.A_constrained_columns * d0;
    Points x = d0;
    if (d_.positions.free_count() > 0) {
      MatX y = d_.B.transpose() * b;
      d_.factor.solve_in_place(y);
      d_.coupling.apply(y, equation_rates(rates, d0));
      x += d_.positions.D() * y;
    }
    Points result = Points::Zero(d_.mesh.vertex_count(), 3);
    for (int v = 0; v < d_.mesh.vertex_count(); ++v)
      if (const int h = d_.system.constrained_by[v]; h == DeformSystem::kFree)
        result.row(v) = x.row(d_.system.dof[v]);
      else if (h >= 0)
        result.row(v) = handle_rate(h, v, rates.handles[h]).transpose();
    return result;
  }

  DeformEditRates gradient(const Points& weights) {
    DeformEditRates result(d_.problem);
    Points d0 = Points::Zero(isize(d_.system.vertex), 3);
    for (int v = 0; v < d_.mesh.vertex_count(); ++v)
      if (const int h = d_.system.constrained_by[v]; h == DeformSystem::kFree)
        d0.row(d_.system.dof[v]) += weights.row(v);
      else if (h >= 0)
        add_handle(h, v, weights.row(v).transpose(), result.handles[h]);
    Points q = Points::Zero(d0.rows(), 3);
    if (d_.positions.free_count() > 0) {
      MatX y = d_.positions.D().transpose() * d0;
      d_.factor.solve_in_place(y);
      d_.coupling.apply(y, VecX::Zero(d_.g.size()));
      VecX multipliers = VecX::Zero(d_.coupling.constraint_count());
      d_.coupling.add_multipliers(multipliers);
      const RowPoints b = d_.B * y;
      for (long i = 0; i < b.rows(); ++i) add_target(i, b.row(i).transpose(), result, q);
      d0 -= Points(d_.A_constrained_columns.transpose() * b);
      add_equations(multipliers, result, d0);
    }
    const MatX rhs = d_.positions.rhs_to_particular().transpose() * d0;
    for (long k = 0; k < rhs.rows(); ++k) add_value(k, rhs.row(k).transpose(), result, q);
    const MatX rotations = d_.rotations.transposed_rates(q);
    for (long h = 0; h < rotations.rows(); ++h)
      result.handles[h].rotation_vector += rotations.row(h).transpose();
    return result;
  }

 private:
  using Kind = DeformSystem::Value::Kind;

  /// A vector s R(q) v, where s is the scale of a feature or handle (-1: 1), and R the rotation of a
  /// dof (-1: none).
  struct Rotated {
    int scaled_by = -1, dof = -1;
    Vec3 vector = Vec3::Zero();
    int target = -1;  // of which the vector is `factor` times the target; -1: constant
    double factor = 1;
    Vec3 shift = Vec3::Zero();  // added to the rotated vector before it is scaled
  };

  Vec3 turned(const Rotated& r) const {
    return r.dof < 0 ? r.vector : rotated(d_.last_valid_q.row(r.dof).transpose(), r.vector);
  }
  double scale_rate(int scaled_by, const DeformEditRates& rates) const {
    return scaled_by < 0           ? 0
           : scaled_by < features_ ? rates.feature_scales[scaled_by]
                                   : rates.handles[scaled_by - features_].scale;
  }

  Vec3 rate(const Rotated& r, const DeformEditRates& rates, const Points& dq) const {
    const Vec3 now = turned(r);
    Vec3 change = Vec3::Zero();
    if (r.dof >= 0) {
      const Vec3 log = d_.last_valid_q.row(r.dof).transpose();
      change = left_jacobian(log, dq.row(r.dof).transpose()).cross(now);
      if (r.target >= 0) change += rotated(log, r.factor * rates.targets[r.target]);
    } else if (r.target >= 0) {
      change = r.factor * rates.targets[r.target];
    }
    return d_.scale_of(d_.last, r.scaled_by) * change +
           scale_rate(r.scaled_by, rates) * (now + r.shift);
  }

  void add(const Rotated& r, const Vec3& weight, DeformEditRates& result, Points& q) const {
    const Vec3 now = turned(r);
    const double scale = d_.scale_of(d_.last, r.scaled_by), share = weight.dot(now + r.shift);
    if (r.scaled_by >= features_)
      result.handles[r.scaled_by - features_].scale += share;
    else if (r.scaled_by >= 0)
      result.feature_scales[r.scaled_by] += share;
    const Vec3 log = r.dof < 0 ? Vec3(Vec3::Zero()) : Vec3(d_.last_valid_q.row(r.dof).transpose());
    if (r.dof >= 0) q.row(r.dof) += scale * left_jacobian(-log, now.cross(weight)).transpose();
    if (r.target >= 0) result.targets[r.target] += scale * r.factor * rotated(-log, weight);
  }

  /// The right-hand side of a hard constraint of a feature or of DeformProblem::rows.
  Rotated value(long k) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (value.kind == Kind::Feature)
      return {value.source, d_.system.feature_dof[value.source],
              (d_.system.rest.row(value.vertex) - d_.system.rest.row(value.reference)).transpose()};
    const LinearConstraint& row = d_.problem.rows[value.source];
    return {-1, row.rotates_with >= 0 ? d_.system.dof[row.rotates_with] : -1,
            d_.last.targets.empty() ? row.target : d_.last.targets[value.source], value.source};
  }
  /// The target of a soft row.
  Rotated target(long i) const {
    Rotated r{d_.system.scaled_by[i], d_.system.rotates_with[i], d_.system.base.row(i).transpose()};
    if (const int row = d_.system.linear_constraint_of_row[i]; row >= 0) {
      r.vector = d_.unrotated_target(d_.last, i);
      r.target = row;
      r.factor = std::sqrt(*d_.problem.rows[row].weight);
      double sum = 0;
      for (RowMatrix::InnerIterator a(d_.system.A, i); a; ++a) sum += a.value();
      r.shift = -sum * d_.system.origin;
    }
    return r;
  }

  bool is_constant(long k) const {
    const Kind kind = d_.system.values[k].kind;
    return kind == Kind::Fixed || kind == Kind::CoincidentVertices;
  }
  Vec3 value_rate(long k, const DeformEditRates& rates, const Points& dq) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (is_constant(k)) return Vec3::Zero();
    if (value.kind == Kind::Handle)
      return handle_rate(value.source, value.vertex, rates.handles[value.source]);
    return rate(this->value(k), rates, dq);
  }
  void add_value(long k, const Vec3& weight, DeformEditRates& result, Points& q) const {
    const DeformSystem::Value& value = d_.system.values[k];
    if (is_constant(k)) return;
    if (value.kind == Kind::Handle)
      add_handle(value.source, value.vertex, weight, result.handles[value.source]);
    else
      add(this->value(k), weight, result, q);
  }
  Vec3 target_rate(long i, const DeformEditRates& rates, const Points& dq) const {
    return rate(target(i), rates, dq);
  }
  void add_target(long i, const Vec3& weight, DeformEditRates& result, Points& q) const {
    add(target(i), weight, result, q);
  }

  Vec3 handle_rate(int h, int vertex, const DeformEditRates::Handle& rates) const {
    const HandleTransform& move = d_.last.handles[h];
    const Vec3 arm = rotated(move.rotation_vector, d_.mesh.point(vertex) - move.about);
    return rates.translation + rates.scale * arm +
           move.scale * left_jacobian(move.rotation_vector, rates.rotation_vector).cross(arm);
  }
  void add_handle(int h, int vertex, const Vec3& weight, DeformEditRates::Handle& result) const {
    const HandleTransform& move = d_.last.handles[h];
    const Vec3 arm = rotated(move.rotation_vector, d_.mesh.point(vertex) - move.about);
    result.translation += weight;
    result.scale += weight.dot(arm);
    result.rotation_vector += move.scale * left_jacobian(-move.rotation_vector, arm.cross(weight));
  }

  VecX equation_rates(const DeformEditRates& rates, const MatX& d0) const {
    VecX g(d_.g.size());
    for (long k = 0; k < g.size(); ++k) {
      const int constraint = d_.constraint_of_equation[k];
      const Vec3& n = d_.equation_directions[k];
      g[k] = n.dot(rates.constraint_origins[constraint]);
      for (const auto& e : d_.problem.point_constraints[constraint].point.entries)
        g[k] -= e.coefficient * n.dot(d0.row(d_.system.dof[e.vertex]));
    }
    return g;
  }
  void add_equations(const VecX& multipliers, DeformEditRates& result, Points& d0) const {
    for (long k = 0; k < multipliers.size(); ++k) {
      const int constraint = d_.constraint_of_equation[k];
      const Vec3 part = multipliers[k] * d_.equation_directions[k];
      result.constraint_origins[constraint] += part;
      for (const auto& e : d_.problem.point_constraints[constraint].point.entries)
        d0.row(d_.system.dof[e.vertex]) -= e.coefficient * part.transpose();
    }
  }

  FormFeatureData& d_;
  int features_;
};

/// Checks that the last solution has derivatives.
void require_derivatives(const FormFeatureData& d) {
  if (!d.solved || d.is_estimated)
    throw InputError("derivatives without an edit: call deform() without an estimate first");
}

}  // namespace

Points FormFeatureDeformer::tangent(const DeformEditRates& rates) {
  require_derivatives(*data_);
  check(data_->problem, rates);
  return EditDerivatives(*data_).tangent(rates);
}

DeformEditRates FormFeatureDeformer::gradient(const Points& weights) {
  require_derivatives(*data_);
  if (weights.rows() != data_->mesh.vertex_count() || !weights.allFinite())
    throw InputError("found " + std::to_string(weights.rows()) + " weights, expected " +
                     std::to_string(data_->mesh.vertex_count()) + " with finite numbers");
  return EditDerivatives(*data_).gradient(weights);
}

}  // namespace batten
