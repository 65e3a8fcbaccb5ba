// SPDX-License-Identifier: MPL-2.0
// Derivatives of a Deformer.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "batten/core/errors.h"
#include "batten/scenes/mesh.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/meshes/edit_session.h"

namespace batten {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// Derivatives at the last edit of a deformer.
class EditDerivatives {
 public:
  explicit EditDerivatives(detail::DeformerState& state)
      : state_(state), base_(complete(state)), size_(state.mesh.data().mesh().size()) {}

  DeformEditRates zero() const { return DeformEditRates(state_.problem()); }

  /// The tangent of RotationMode::Harmonic; otherwise central differences of order four, whose step
  /// changes the mesh by about 0.2 % of its size.
  Points along(const DeformEditRates& rates) {
    if (state_.linear) return node_positions(state_.linear->tangent(rates), file());
    constexpr double target = 2e-3;
    const double rate = largest(rates);
    if (!std::isfinite(rate)) throw InputError("rates: found a number that is not finite");
    if (rate == 0) return Points::Zero(state_.mesh.points().rows(), 3);
    const double h = target / rate;
    const Points near = positions(rates, h) - positions(rates, -h);
    return (8 * near - (positions(rates, 2 * h) - positions(rates, -2 * h))) / (12 * h);
  }

  /// The gradient of Σ weights · positions (RotationMode::Harmonic only).
  std::optional<DeformEditRates> gradient(const Points& weights) {
    if (!state_.linear) return {};
    Points of_vertices = Points::Zero(state_.linear->mesh().vertex_count(), 3);
    of_vertices.topRows(weights.rows()) = weights;
    return state_.linear->gradient(of_vertices);
  }

  /// Solves the last edit again.
  void restore() { state_.deform(state_.last, state_.last_correct); }

 private:
  const MeshFile& file() const { return state_.mesh.data().source.file; }
  static DeformEdit complete(const detail::DeformerState& state) {
    DeformEdit edit = state.last;
    const DeformProblem& problem = state.problem();
    if (edit.feature_scales.empty()) edit.feature_scales.assign(problem.features.size(), 1);
    if (edit.targets.empty())
      for (const LinearConstraint& row : problem.rows) edit.targets.push_back(row.target);
    return edit;
  }

  /// The largest rate, relative to the size of the mesh.
  double largest(const DeformEditRates& rates) const {
    double sum = 0;  // NaN and infinity remain
    for (const auto& h : rates.handles)
      sum += h.translation.norm() / size_ + h.rotation_vector.norm() + std::abs(h.scale);
    for (const double s : rates.feature_scales) sum += std::abs(s);
    for (const auto* points : {&rates.constraint_origins, &rates.targets})
      for (const Vec3& p : *points) sum += p.norm() / size_;
    return sum;
  }

  Points positions(const DeformEditRates& rates, double step) {
    DeformEdit edit = base_;
    for (size_t h = 0; h < edit.handles.size(); ++h) {
      edit.handles[h].translation += step * rates.handles[h].translation;
      edit.handles[h].rotation_vector += step * rates.handles[h].rotation_vector;
      edit.handles[h].scale += step * rates.handles[h].scale;
    }
    for (size_t f = 0; f < edit.feature_scales.size(); ++f)
      edit.feature_scales[f] += step * rates.feature_scales[f];
    for (size_t k = 0; k < edit.constraint_origins.size(); ++k)
      edit.constraint_origins[k] += step * rates.constraint_origins[k];
    for (size_t r = 0; r < edit.targets.size(); ++r) edit.targets[r] += step * rates.targets[r];
    state_.deform(edit, true);
    return node_positions(state_.positions(), file());
  }

  detail::DeformerState& state_;
  DeformEdit base_;
  double size_;
};

/// Calls `f` for derivatives at the last edit, and solves this edit again afterwards.
template <class Function>
auto at_last_edit(detail::DeformerState& state, const Function& f) {
  return state.serialize([&] {
    EditDerivatives derivatives(state);
    if (state.linear) derivatives.restore();
    try {
      auto result = f(derivatives);
      if (!state.linear) derivatives.restore();
      return result;
    } catch (...) {
      derivatives.restore();
      throw;
    }
  });
}

DeformEditRates rates_of(const DeformerRates& given, const DeformProblem& problem,
                         DeformEditRates rates) {
  for (const auto& [name, rate] : given.moves)
    rates.handles[detail::index_of_name(name, problem.handles, "moves", "handle")] = {
        rate.translate, rate.rotation * kRadians, rate.scale};
  for (const auto& [name, rate] : given.scales)
    rates.feature_scales[detail::index_of_name(name, problem.features, "scales", "feature")] = rate;
  for (const auto& [name, rate] : given.origins)
    rates.constraint_origins[detail::index_of_name(name, problem.point_constraints, "origins",
                                                   "constraint")] = rate;
  for (const auto& [name, rate] : given.targets)
    rates.targets[detail::index_of_name(name, problem.rows, "targets", "linear constraint")] = rate;
  return rates;
}

/// Component of the gradient for one number of the rates, which `number` selects.
template <class Number>
double component(EditDerivatives& derivatives, const Points& weights, const Number& number) {
  DeformEditRates rates = derivatives.zero();
  number(rates) = 1;
  return derivatives.along(rates).cwiseProduct(weights).sum();
}

/// Three components, of the vector that `vector` selects.
template <class Vector>
Vec3 components(EditDerivatives& derivatives, const Points& weights, const Vector& vector) {
  Vec3 gradient;
  for (int i = 0; i < 3; ++i)
    gradient[i] = component(derivatives, weights,
                            [&](DeformEditRates& rates) -> double& { return vector(rates)[i]; });
  return gradient;
}

/// The gradient, one product for each number.
DeformEditRates gradient_by_differences(EditDerivatives& derivatives, const DeformProblem& problem,
                                        const Points& weights) {
  DeformEditRates gradient(problem);
  for (size_t h = 0; h < problem.handles.size(); ++h) {
    auto& handle = gradient.handles[h];
    handle.translation = components(derivatives, weights, [&](DeformEditRates& r) -> Vec3& {
      return r.handles[h].translation;
    });
    handle.rotation_vector = components(derivatives, weights, [&](DeformEditRates& r) -> Vec3& {
      return r.handles[h].rotation_vector;
    });
    handle.scale = component(derivatives, weights,
                             [&](DeformEditRates& r) -> double& { return r.handles[h].scale; });
  }
  for (size_t f = 0; f < problem.features.size(); ++f)
    gradient.feature_scales[f] = component(
        derivatives, weights, [&](DeformEditRates& r) -> double& { return r.feature_scales[f]; });
  for (size_t k = 0; k < problem.point_constraints.size(); ++k)
    gradient.constraint_origins[k] = components(
        derivatives, weights, [&](DeformEditRates& r) -> Vec3& { return r.constraint_origins[k]; });
  for (size_t k = 0; k < problem.rows.size(); ++k)
    gradient.targets[k] =
        components(derivatives, weights, [&](DeformEditRates& r) -> Vec3& { return r.targets[k]; });
  return gradient;
}

/// The gradient by name, with angles in degrees.
DeformerRates named(const DeformEditRates& gradient, const DeformProblem& problem) {
  DeformerRates result;
  for (size_t h = 0; h < problem.handles.size(); ++h) {
    const auto& handle = gradient.handles[h];
    result.moves[problem.handles[h].name] = {handle.translation, handle.rotation_vector * kRadians,
                                             handle.scale};
  }
  for (size_t f = 0; f < problem.features.size(); ++f)
    result.scales[problem.features[f].name] = gradient.feature_scales[f];
  for (size_t k = 0; k < problem.point_constraints.size(); ++k)
    result.origins[problem.point_constraints[k].name] = gradient.constraint_origins[k];
  for (size_t k = 0; k < problem.rows.size(); ++k)
    result.targets[problem.rows[k].name] = gradient.targets[k];
  return result;
}

}  // namespace

Points Deformer::jvp(const DeformerRates& rates) {
  return at_last_edit(*state_, [&](EditDerivatives& derivatives) {
    return derivatives.along(rates_of(rates, state_->problem(), derivatives.zero()));
  });
}

DeformerRates Deformer::vjp(const Points& weights) {
  const long nodes = mesh().points().rows();
  if (weights.rows() != nodes || !weights.allFinite())
    throw InputError("weights: found " + std::to_string(weights.rows()) +
                     " rows, expected one with finite numbers for each of the " +
                     std::to_string(nodes) + " nodes");
  return at_last_edit(*state_, [&](EditDerivatives& derivatives) {
    const DeformProblem& problem = state_->problem();
    const std::optional<DeformEditRates> exact = derivatives.gradient(weights);
    return named(exact ? *exact : gradient_by_differences(derivatives, problem, weights), problem);
  });
}

}  // namespace batten
