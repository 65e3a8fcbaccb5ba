// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_refinement.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "batten/analysis/models/parent_triangles.h"
#include "batten/analysis/models/stress_convergence.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/refinement.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {
namespace {

void require_valid(const ShellRefinementOptions& options) {
  if (!(options.accuracy > 0))
    throw InputError("found an accuracy of " + format_number(options.accuracy) +
                     ", expected a number above 0");
  if (options.max_meshes < 1)
    throw InputError("found at most " + std::to_string(options.max_meshes) +
                     " meshes, expected 1 or more");
  if (!(options.bulk_fraction > 0 && options.bulk_fraction <= 1))
    throw InputError("found the fraction " + format_number(options.bulk_fraction) +
                     " of the error, expected a number above 0, up to 1");
}

double mean_edge_length(const ModelLayout& layout, const Points& shape) {
  double area = 0, triangles = 0;
  for (int r = 0; r < layout.region_count(); ++r) {
    const Surface surface(layout.region(r).mesh(), layout.element(), layout.region_dofs(r, shape));
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      area += surface.mesh().shape(t).area *
              surface.jet({t, Vec3::Constant(1.0 / 3)}).area_vector().norm();
      ++triangles;
    }
  }
  return std::sqrt(2 * area / triangles);
}

// Contributions to the estimated errors of displacements: relative errors, one per triangle.
VecX contributions(const VecX& indicators, double error) {
  const double sum = indicators.sum();
  return sum > 0 ? VecX(indicators * (error / sum)) : indicators;
}

double estimated_error(const std::vector<ShellCaseResult>& cases) {
  double error = 0;
  for (const ShellCaseResult& c : cases) {
    error = std::max(error, std::pow(c.energy_norm_error, 2));
    if (c.max_displacement.value > 0)
      error = std::max(error, c.max_displacement.error / c.max_displacement.value);
  }
  return error;
}

// How often each triangle is bisected for the displacements. Bisections of a smooth solution divide
// the contribution of a triangle by 8: one that contributes 8^k times as much as the least marked
// triangle is bisected k + 1 times.
std::vector<int> bisections(const VecX& indicators, double bulk_fraction) {
  std::vector<int> levels(static_cast<size_t>(indicators.size()), 0);
  const std::vector<int> marked = dorfler_marking(indicators, bulk_fraction);
  constexpr int most = 4;
  for (const int t : marked) {
    const double excess = indicators[t] / indicators[marked.back()];
    levels[static_cast<size_t>(t)] =
        std::isfinite(excess) ? std::clamp(1 + static_cast<int>(std::log2(excess) / 3), 1, most)
                              : 1;
  }
  return levels;
}

// Ratio of the whole error to the estimate. The estimate compares the solution with a smoother one,
// which is about that of a mesh with halved elements. If halving the elements multiplies the
// contributions by q, the whole error is the sum of a geometric series, 1/(1 - q) times the estimate:
// 1.07 for smooth solutions, and 4.1 at a simply supported corner of 150 degrees.
class ErrorRatio {
 public:
  static constexpr double most = 5;

  void refine(const ModelLayout& before, const VecX& contributions,
              const std::vector<int>& levels) {
    before_ = std::make_unique<const ModelLayout>(before);
    contributions_ = contributions;
    levels_ = levels;
  }
  // The ratio on the next mesh.
  double update(const ModelLayout& refined, const VecX& contributions) {
    if (!before_) return value_;
    double sum_before = 0, sum = 0, weighted_levels = 0;
    for (size_t t = 0; t < levels_.size(); ++t) {
      if (levels_[t] == 0) continue;
      sum_before += contributions_[static_cast<long>(t)];
      weighted_levels += levels_[t] * contributions_[static_cast<long>(t)];
    }
    const std::vector<int> parents = ParentTriangles(*before_).of_all(refined);
    for (size_t t = 0; t < parents.size(); ++t)
      if (levels_[static_cast<size_t>(parents[t])] > 0) sum += contributions[static_cast<long>(t)];
    // Few of the contributions, where only stresses are refined, say little.
    if (!(sum_before > 0.5 * contributions_.sum())) return value_;
    // Over two rounds: a bisection shortens the edges in one direction, and the next one in the other.
    const double halvings = 0.5 * weighted_levels / sum_before;
    const double log_reduction = std::log(sum / sum_before);
    const double q = std::exp((log_reduction + log_reduction_) / (halvings + halvings_));
    log_reduction_ = log_reduction;
    halvings_ = halvings;
    return value_ = 1 / std::max(1 - q, 1 / most);
  }

 private:
  std::unique_ptr<const ModelLayout> before_;
  VecX contributions_;
  std::vector<int> levels_;
  double log_reduction_ = 0, halvings_ = 0;  // of the last round
  double value_ = std::sqrt(most);           // of the first mesh, whose q is unknown
};

// The rounds of refine_shell().
class Refinement {
 public:
  Refinement(std::shared_ptr<const ModelLayout> layout, const Points& shape,
             const ShellProblem& problem, const ShellRefinementOptions& options,
             const Progress& progress)
      : options_(options),
        problem_(problem),
        progress_(progress),
        first_layout_(layout),
        first_(*first_layout_),
        first_edge_lengths_(triangle_edge_lengths(layout->surface(shape))) {
    result_.layout = std::move(layout);
    result_.shape = shape;
  }

  RefinedShell run() {
    analyse(result_.layout, result_.shape);
    while (!result_.converged && isize(result_.meshes) < options_.max_meshes) {
      try {
        if (!refine()) break;
      } catch (const MemoryError&) {
        break;  // keep the largest mesh that fits into memory
      } catch (const NoSolutionError&) {
        break;  // too small elements for the precision of the numbers
      }
    }
    for (const StressConvergence& of : stresses_)
      result_.singular_places.push_back(of.singular_places());
    return std::move(result_);
  }

 private:
  // Triangles far smaller than the thickness add digits to the theory, not to the shell.
  bool is_small(const Surface& surface, int triangle) const {
    constexpr double small = 1e-3;
    return triangle_edge_length(surface, triangle) <
           small * result_.shell->assembler().section(triangle).thickness;
  }

  // Analyses the next mesh. Returns false if there is nothing to refine, or beyond the limit of
  // unknowns.
  bool refine() {
    progress_.update("mesh " + std::to_string(result_.meshes.size() + 1), 0);
    const Surface surface = result_.layout->surface(result_.shape);
    VecX reducible = contributions_;
    for (int t = 0; t < reducible.size(); ++t)
      if (is_small(surface, t)) reducible[t] = 0;
    std::vector<int> levels(static_cast<size_t>(reducible.size()), 0);
    if (!(checked_error_ <= options_.accuracy))
      levels = bisections(reducible, options_.bulk_fraction);
    for (const StressConvergence& of : stresses_) of.mark(surface, levels);
    for (int t = 0; t < reducible.size(); ++t)
      if (is_small(surface, t)) levels[static_cast<size_t>(t)] = 0;
    if (std::all_of(levels.begin(), levels.end(), [](int level) { return level == 0; }))
      return false;
    const auto finer = std::make_shared<const ModelLayout>(bisected(*result_.layout, levels));
    const Points dofs = interpolate_onto(*result_.layout, result_.shape, *finer);
    total_unknowns_ += 3 * dofs.rows();
    if (options_.max_total_unknowns > 0 && total_unknowns_ > options_.max_total_unknowns)
      return false;
    ratio_.refine(*result_.layout, contributions_, levels);
    analyse(finer, dofs);
    return true;
  }

  void analyse(const std::shared_ptr<const ModelLayout>& layout, const Points& dofs) {
    result_.shell.reset();  // two factors at once may not fit into memory
    const ShellDefinition definition = problem_.definition(*layout, dofs);
    const auto shell = std::make_shared<const ShellModel>(*layout, dofs, definition,
                                                          ShellModel::RigidBodyHandling::Refused,
                                                          options_.backend_factory);
    std::vector<ShellLoadCase> load_cases = problem_.load_cases(*layout, dofs, definition);
    while (stresses_.size() < load_cases.size())

      stresses_.emplace_back(first_, first_edge_lengths_, options_.accuracy);
    for (size_t c = 0; c < load_cases.size(); ++c)
      load_cases[c].singular_places = stresses_[c].singular_places();
    size_t index = 0;
    const auto follow = [&](const ShellCaseResult& of, const ShellStresses& recovered) {
      stresses_[index].take(*shell, load_cases[index], of, recovered);
      ++index;
    };
    VecX indicators;
    const std::vector<ShellCaseResult> cases =
        evaluate_load_cases(*shell, load_cases, follow, &indicators, progress_);
    record(*layout, dofs, *shell, cases, indicators);
    result_.layout = layout;
    result_.shape = dofs;
    result_.shell = shell;
  }

  void record(const ModelLayout& layout, const Points& dofs, const ShellModel& shell,
              const std::vector<ShellCaseResult>& cases, const VecX& indicators) {
    const double estimate = estimated_error(cases);
    contributions_ = contributions(indicators, estimate);
    result_.error_ratio = ratio_.update(layout, contributions_);
    RefinedShell::Mesh mesh;
    mesh.edge_length = mean_edge_length(layout, dofs);
    mesh.unknowns = shell.unknowns();
    mesh.error = result_.error_ratio * estimate;
    for (size_t c = 0; c < cases.size(); ++c) {
      mesh.displacement = std::max(mesh.displacement, cases[c].max_displacement.value);
      mesh.von_mises = std::max(mesh.von_mises, stresses_[c].peak().value);
      mesh.stress_error = std::max(mesh.stress_error, stresses_[c].error());
    }
    result_.meshes.push_back(mesh);
    checked_error_ = result_.meshes.size() == 1 ? ErrorRatio::most * estimate : mesh.error;
    result_.converged =
        checked_error_ <= options_.accuracy && mesh.stress_error <= options_.accuracy;
  }

  const ShellRefinementOptions& options_;
  const ShellProblem& problem_;
  const Progress& progress_;
  std::shared_ptr<const ModelLayout> first_layout_;
  ParentTriangles first_;
  std::vector<double> first_edge_lengths_;
  std::vector<StressConvergence> stresses_;  // of each load case
  ErrorRatio ratio_;
  VecX contributions_;
  double checked_error_ = 0;  // of the displacements; on the first mesh, the largest possible one
  long total_unknowns_ = 0;
  RefinedShell result_;
};

}  // namespace

RefinedShell refine_shell(std::shared_ptr<const ModelLayout> layout, const Points& shape,
                          const ShellProblem& problem, const ShellRefinementOptions& options,
                          const Progress& progress) {
  require_valid(options);
  progress.update("mesh 1", 0);
  return Refinement(std::move(layout), shape, problem, options, progress).run();
}

}  // namespace batten
