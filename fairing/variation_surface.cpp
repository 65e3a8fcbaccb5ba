#include "batten/fairing/variation_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "batten/core/elimination_order.h"
#include "batten/core/errors.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/fairing/fairable.h"
#include "batten/fairing/held_rows.h"
#include "batten/fairing/normal_steps.h"
#include "batten/fairing/step_equations.h"
#include "batten/fairing/variation_terms.h"

namespace batten {
namespace {

// The largest move of a vertex along the normal.
double normal_move(const Surface& from, const Surface& to) {
  double most = 0;
  for (int v = 0; v < from.mesh().vertex_count(); ++v) {
    const int d = from.dof_map().vertex(v);
    const Vec3 u = from.dofs().row(d + 1), w = from.dofs().row(d + 2);
    const Vec3 way = to.dofs().row(d) - from.dofs().row(d);
    most = std::max(most, std::abs(u.cross(w).normalized().dot(way)));
  }
  return most;
}

// An order for the factor of A; `copies`: its unknowns are so many times the same ones.
std::vector<int> order_of(const SparseMatrix& A, int copies) {
  const int each = static_cast<int>(A.rows()) / copies;
  std::vector<int> all;
  for (const int f : elimination_order(A.topLeftCorner(each, each), Expected::many_factors))
    for (int c = 0; c < copies; ++c) all.push_back(c * each + f);
  return all;
}

// First along the normals, with a third of the unknowns, then along all ways: (u, v) must run
// smoothly over the shape before the elements come near to it.
class Descent {
 public:
  /// Reduction and rows must outlive it.
  Descent(const Surface& start, const StackedReduction& reduction, const HeldRows& held,
          const VariationOptions& options)
      : reduction_(reduction),
        held_(held),
        surface_(start.shared_mesh(), start.kind(), on_rows(start.dofs()), start.trim()),
        terms_(surface_, options.gauss, options.jumps, options.still) {
    for (const auto& side : options.sides) terms_.add_side(surface_, side);
    terms_.add_joins(surface_, options.joins);
  }

  const Surface& surface() const { return surface_; }
  double value() const { return terms_.value(surface_); }
  double value_of(const Surface& other) {
    terms_.set_frames(other);
    return terms_.value(other);
  }

  void run(const VariationOptions& options, const Progress& progress, VariationSurface& result) {
    const NormalSteps normal(reduction_, surface_);
    if (normal.count() > 0)
      run([&] { return normal.at(surface_); }, normal.of_unknowns(held_.rows()), 1, 2e-3, options,
          progress, result);
    if (reduction_.free_count() > 0) {
      evenness_ = least_evenness;
      damping_ = least_damping;
      run([&] { return reduction_.D(); }, held_.of_unknowns(), reduction_.coupled() ? 1 : 3, 5e-4,
          options, progress, result);
    }
  }

 private:
  struct Step {
    bool taken = false;
    double promised = 0;                  ///< the most of any try
    double gain = 0, kept = 0, move = 0;  ///< kept: gain over promise, 0 for a part of a step
  };
  static constexpr double least_evenness = 0.3, least_damping = 1e-4;
  static constexpr double poor = 0.25;    // share of the promise
  static constexpr double little = 0.03;  // of the functional: not worth a step

  // Steps until one moves the shape by less than `calm` of its size, or gains little.
  template <class Ways>
  void run(const Ways& ways, const RowMatrix& held, int copies, double calm,
           const VariationOptions& options, const Progress& progress, VariationSurface& result) {
    T_ = ways();
    StepEquations equations(terms_, surface_, T_, held);
    SparseCholesky cholesky;
    cholesky.analyze(equations.matrix(), order_of(equations.matrix(), copies));
    const double length = terms_.length();
    int idle = 0;  // steps in a row that gained little
    result.converged = false;
    while (result.iterations < options.most_iterations && !result.converged) {
      progress.at("fairing", static_cast<double>(result.iterations) / options.most_iterations);
      const Step step = descend(equations, cholesky, result);
      if (!step.taken) {
        result.converged = step.promised < little * value_;  // otherwise it is stuck
        return;
      }
      ++result.iterations;
      terms_.set_frames(surface_);
      // Other frames may take back what the step gained in its own.
      const bool gained_little =
          step.gain < little * value_ && value_ - terms_.value(surface_) < little * value_;
      idle = gained_little ? idle + 1 : 0;
      result.converged =
          idle > 1 || (step.kept > poor && (step.move < calm * length || gained_little));
      if (!result.converged) T_ = ways();
    }
  }

  void tighten() {
    damping_ = std::max(8 * damping_, 1e-2);
    evenness_ = std::min(4 * evenness_, 100.0);
  }

  // After a step that was taken at the try k and kept this share of its promise.
  void relax(double kept, int k) {
    if (kept < poor) return tighten();
    const double factor = kept < 0.6 ? 1 : k > 0 ? 0.5 : kept < 0.9 ? 0.3 : 0.1;
    damping_ = std::max(least_damping, factor * damping_);
    if (evenness_ > 0) evenness_ = std::max(least_evenness, factor * evenness_);
  }

  StepWeights weights() const { return {damping_, damping_ + evenness_}; }

  Step descend(StepEquations& equations, SparseCholesky& cholesky, VariationSurface& result) {
    constexpr int most_tries = 12;
    Step step;
    for (int k = 0; k < most_tries; ++k) {
      value_ = equations.assemble(terms_, surface_, weights(), T_);
      if (!std::isfinite(value_))
        throw InputError("the surface to be faired has no normal somewhere");
      ++result.factorizations;
      if (!cholesky.factorize(equations.matrix())) {
        if (k + 1 == most_tries) throw NoSolutionError(cholesky.message());
        tighten();
        continue;
      }
      const VecX way = equations.step(cholesky);
      const double promised = -equations.gradient().dot(way);
      step.promised = std::max(step.promised, promised);
      // A part of the step costs a value, another step a factor.
      for (double part = 1; part > 0.1; part /= 2) {
        const Surface next = moved(part * way);
        step.gain = value_ - terms_.value(next);
        if (!(step.gain > 0)) continue;
        step.taken = true;
        step.move = normal_move(surface_, next);
        surface_ = next;
        step.kept = part < 1 ? 0 : step.gain / promised;
        relax(step.kept, k);
        return step;
      }
      if (promised < little * value_) break;
      tighten();
    }
    return step;
  }

  Surface moved(const VecX& way) const {
    const VecX change = T_ * way;
    const Points x = surface_.dofs() + change.reshaped(reduction_.dof_count(), 3);
    return {surface_.shared_mesh(), surface_.kind(), on_rows(x), surface_.trim()};
  }

  Points on_rows(const Points& dofs) const {
    Points x = reduction_.expand(reduction_.free_part(dofs));
    held_.put_on(x);
    return x;
  }

  const StackedReduction& reduction_;
  const HeldRows& held_;
  Surface surface_;
  VariationTerms terms_;
  RowMatrix T_;
  double value_ = 0, evenness_ = 0, damping_ = 1e-2;
};

StackedReduction reduction_of(const Surface& start, const ConstraintSet& constraints,
                              const VariationOptions& options) {
  StackedReduction all(HeldRows::few_dofs(constraints));
  if (options.still.empty()) return all;
  std::vector<char> still(start.dof_map().count(), 0);
  for (int t = 0; t < start.mesh().triangle_count(); ++t)
    if (options.still[t])
      for (const int dof : start.dof_map().triangle(start.mesh(), t)) still[dof] = 1;
  return {all, start.dofs(), still};
}

}  // namespace

VariationSurface fair_variation(const Surface& start, const ConstraintSet& constraints,
                                const VariationOptions& options, const Progress& progress) {
  if (start.kind() != TriangleElement::HCT)
    throw InputError("found Z12 triangles, expected HCT: their third derivatives are needed");
  if (!(options.strength > 0 && options.strength <= 1) || !(options.largest_move > 0))
    throw InputError("expected a strength above 0, at most 1, and a largest move above 0");
  require_fairable(start, constraints);
  const StackedReduction reduction = reduction_of(start, constraints, options);
  const HeldRows held(HeldRows::many_dofs(constraints), reduction, start);
  VariationSurface result;
  std::unique_ptr<Descent> best;
  const auto consider = [&](const Points& dofs) {
    auto descent = std::make_unique<Descent>(
        Surface(start.shared_mesh(), start.kind(), dofs, start.trim()), reduction, held, options);
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
  result.share = std::min(options.strength, move > 0 ? options.largest_move / move : 1);
  result.max_move = result.share * move;
  result.dofs = whole.dofs();
  if (result.share < 1) result.dofs = start.dofs() + result.share * (whole.dofs() - start.dofs());
  result.functional =
      descent.value_of(Surface(start.shared_mesh(), start.kind(), result.dofs, start.trim()));
  result.max_residual = constraints.max_residual(result.dofs);
  return result;
}

}  // namespace batten
