// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/minimum_variation/minimum_variation_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "batten/core/errors.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fairing/minimum_variation/block_reduction.h"
#include "batten/fairing/minimum_variation/curvature_variation_terms.h"
#include "batten/fairing/minimum_variation/gauss_newton_system.h"

namespace batten {
namespace {

// Largest move of a vertex along the normal of `from`.
double normal_move(const Surface& from, const Surface& to) {
  double most = 0;
  for (int v = 0; v < from.mesh().vertex_count(); ++v) {
    const int d = from.dof_map().vertex(v);
    const Vec3 u = from.dofs().row(d + 1), w = from.dofs().row(d + 2);
    const Vec3 displacement = to.dofs().row(d) - from.dofs().row(d);
    most = std::max(most, std::abs(u.cross(w).normalized().dot(displacement)));
  }
  return most;
}

// Elimination order for A. `copies`: the unknowns are that many copies of the same ones.
std::vector<int> order_of(const SparseMatrix& A, int copies) {
  const int each = static_cast<int>(A.rows()) / copies;
  std::vector<int> all;
  for (const int f : elimination_order(A.topLeftCorner(each, each), FactorReuse::many))
    for (int c = 0; c < copies; ++c) all.push_back(c * each + f);
  return all;
}

// Gauss-Newton descent: first along the normals, with a third of the unknowns, then in all
// directions. (u, v) must run smoothly over the shape before the elements can approximate it.
class Descent {
 public:
  /// `reduction` and `multiplier_constraints` must outlive this object.
  Descent(const Surface& start, const BlockReduction& reduction,
          const AugmentedLagrangianConstraints& multiplier_constraints,
          const MinimumVariationOptions& options)
      : reduction_(reduction),
        multiplier_constraints_(multiplier_constraints),
        surface_(start.shared_mesh(), start.kind(), projected(start.dofs()), start.trim()),
        terms_(surface_, options.gauss, options.jumps, options.frozen) {
    for (const auto& side : options.sides) terms_.add_side(surface_, side);
    terms_.add_joins(surface_, options.joins);
  }

  const Surface& surface() const { return surface_; }
  double value() const { return terms_.value(surface_); }
  double value_of(const Surface& other) {
    terms_.set_frames(other);
    return terms_.value(other);
  }

  void run(const MinimumVariationOptions& options, const Progress& progress,
           MinimumVariationSurface& result) {
    const NormalVariation normal(reduction_, surface_);
    if (normal.count() > 0)
      run([&] { return normal.at(surface_); }, normal.reduced_rows(multiplier_constraints_.rows()),
          1, 2e-3, options, progress, result);
    if (reduction_.free_count() > 0) {
      parametrization_weight_ = kMinParametrizationWeight;
      damping_ = least_damping;
      run([&] { return reduction_.D(); }, multiplier_constraints_.reduced_rows(),
          reduction_.coupled() ? 1 : 3, 5e-4, options, progress, result);
    }
  }

 private:
  struct Step {
    bool taken = false;
    double predicted_decrease = 0;              ///< largest predicted decrease of all tries
    double gain = 0, gain_ratio = 0, move = 0;  ///< gain_ratio: gain / predicted decrease; 0 for a
                                                ///< shortened step
  };
  static constexpr double kMinParametrizationWeight = 0.3, least_damping = 1e-4;
  static constexpr double kPoorGainRatio = 0.25;       // smallest gain ratio of a good step
  static constexpr double kNegligibleDecrease = 0.03;  // fraction of the functional; a smaller
                                                       // decrease is not worth a step

  // Steps until one moves the shape by less than `move_tolerance` of its size, or gains little.
  template <class Basis>
  void run(const Basis& basis, const RowMatrix& multiplier_constraints, int copies,
           double move_tolerance, const MinimumVariationOptions& options, const Progress& progress,
           MinimumVariationSurface& result) {
    T_ = basis();
    GaussNewtonSystem equations(terms_, surface_, T_, multiplier_constraints);
    SparseCholesky cholesky;
    cholesky.analyze(equations.matrix(), order_of(equations.matrix(), copies));
    const double length = terms_.length();
    int stagnant_steps = 0;  // consecutive steps that gained little
    result.converged = false;
    while (result.iterations < options.max_iterations && !result.converged) {
      progress.update("fairing", static_cast<double>(result.iterations) / options.max_iterations);
      const Step step = descend(equations, cholesky, result);
      if (!step.taken) {
        result.converged =
            step.predicted_decrease < kNegligibleDecrease * value_;  // otherwise no step was found
        return;
      }
      ++result.iterations;
      terms_.set_frames(surface_);
      // In new frames, part of the gain may be lost.
      const bool gained_little = step.gain < kNegligibleDecrease * value_ &&
                                 value_ - terms_.value(surface_) < kNegligibleDecrease * value_;
      stagnant_steps = gained_little ? stagnant_steps + 1 : 0;
      result.converged =
          stagnant_steps > 1 || (step.gain_ratio > kPoorGainRatio &&
                                 (step.move < move_tolerance * length || gained_little));
      if (!result.converged) T_ = basis();
    }
  }

  void increase_damping() {
    damping_ = std::max(8 * damping_, 1e-2);
    parametrization_weight_ = std::min(4 * parametrization_weight_, 100.0);
  }

  // Adapts damping to a step that was accepted at try k with this gain ratio.
  void decrease_damping(double gain_ratio, int k) {
    if (gain_ratio < kPoorGainRatio) return increase_damping();
    const double factor = gain_ratio < 0.6 ? 1 : k > 0 ? 0.5 : gain_ratio < 0.9 ? 0.3 : 0.1;
    damping_ = std::max(least_damping, factor * damping_);
    if (parametrization_weight_ > 0)
      parametrization_weight_ =
          std::max(kMinParametrizationWeight, factor * parametrization_weight_);
  }

  DampingWeights weights() const { return {damping_, damping_ + parametrization_weight_}; }

  Step descend(GaussNewtonSystem& equations, SparseCholesky& cholesky,
               MinimumVariationSurface& result) {
    constexpr int most_tries = 12;
    Step step;
    for (int k = 0; k < most_tries; ++k) {
      value_ = equations.assemble(terms_, surface_, weights(), T_);
      if (!std::isfinite(value_))
        throw InputError("the surface to be faired is singular: it has no normal at some point");
      ++result.factorizations;
      if (!cholesky.factorize(equations.matrix())) {
        if (k + 1 == most_tries) throw NoSolutionError(cholesky.message());
        increase_damping();
        continue;
      }
      const VecX displacement = equations.step(cholesky);
      const double predicted_decrease = -equations.gradient().dot(displacement);
      step.predicted_decrease = std::max(step.predicted_decrease, predicted_decrease);
      // A shortened step costs an evaluation, a new step a factorization.
      for (double part = 1; part > 0.1; part /= 2) {
        const Surface next = stepped(part * displacement);
        step.gain = value_ - terms_.value(next);
        if (!(step.gain > 0)) continue;
        step.taken = true;
        step.move = normal_move(surface_, next);
        surface_ = next;
        step.gain_ratio = part < 1 ? 0 : step.gain / predicted_decrease;
        decrease_damping(step.gain_ratio, k);
        return step;
      }
      if (predicted_decrease < kNegligibleDecrease * value_) break;
      increase_damping();
    }
    return step;
  }

  Surface stepped(const VecX& displacement) const {
    const VecX change = T_ * displacement;
    const Points x = surface_.dofs() + change.reshaped(reduction_.dof_count(), 3);
    return {surface_.shared_mesh(), surface_.kind(), projected(x), surface_.trim()};
  }

  Points projected(const Points& dofs) const {
    Points x = reduction_.expand(reduction_.free_part(dofs));
    multiplier_constraints_.project_onto(x);
    return x;
  }

  const BlockReduction& reduction_;
  const AugmentedLagrangianConstraints& multiplier_constraints_;
  Surface surface_;
  CurvatureVariationTerms terms_;
  RowMatrix T_;
  double value_ = 0, parametrization_weight_ = 0, damping_ = 1e-2;
};

BlockReduction reduction_of(const Surface& start, const ConstraintSet& constraints,
                            const MinimumVariationOptions& options) {
  BlockReduction all(AugmentedLagrangianConstraints::sparse_rows(constraints));
  if (options.frozen.empty()) return all;
  std::vector<char> frozen(start.dof_map().count(), 0);
  for (int t = 0; t < start.mesh().triangle_count(); ++t)
    if (options.frozen[t])
      for (const int dof : start.dof_map().triangle(start.mesh(), t)) frozen[dof] = 1;
  return {all, start.dofs(), frozen};
}

}  // namespace

MinimumVariationSurface minimize_curvature_variation(const Surface& start,
                                                     const ConstraintSet& constraints,
                                                     const MinimumVariationOptions& options,
                                                     const Progress& progress) {
  if (start.kind() != TriangleElement::HCT)
    throw InputError(
        "found Z12 elements, expected element = \"hct\": fairing needs third derivatives");
  if (!(options.strength > 0 && options.strength <= 1) || !(options.largest_move > 0))
    throw InputError("expected fair_strength above 0, at most 1, and max_displacement above 0");
  check_fairing_input(start, constraints);
  const BlockReduction reduction = reduction_of(start, constraints, options);
  const AugmentedLagrangianConstraints multiplier_constraints(
      AugmentedLagrangianConstraints::dense_rows(constraints), reduction, start);
  MinimumVariationSurface result;
  std::unique_ptr<Descent> best;
  const auto consider = [&](const Points& dofs) {
    auto descent =
        std::make_unique<Descent>(Surface(start.shared_mesh(), start.kind(), dofs, start.trim()),
                                  reduction, multiplier_constraints, options);
    if (!best || descent->value() < best->value()) best = std::move(descent);
  };
  consider(start.dofs());
  result.start_functional = best->value();
  if (!options.starts.empty()) best.reset();
  for (const Points& dofs : options.starts) consider(dofs);
  Descent& descent = *best;
  descent.run(options, progress, result);
  const Surface& whole = descent.surface();
  const double move = normal_move(start, whole);
  result.fraction = std::min(options.strength, move > 0 ? options.largest_move / move : 1);
  result.max_move = result.fraction * move;
  result.dofs = whole.dofs();
  if (result.fraction < 1)
    result.dofs = start.dofs() + result.fraction * (whole.dofs() - start.dofs());
  result.functional =
      descent.value_of(Surface(start.shared_mesh(), start.kind(), result.dofs, start.trim()));
  result.max_residual = constraints.max_residual(result.dofs);
  return result;
}

}  // namespace batten
