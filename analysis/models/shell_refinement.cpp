// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_refinement.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

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

RefinedShell::Mesh mesh_result(const std::vector<ShellCaseResult>& cases) {
  RefinedShell::Mesh mesh;
  for (const ShellCaseResult& c : cases) {
    const MaxDisplacement& largest = c.max_displacement;
    mesh.displacement = std::max(mesh.displacement, largest.value);
    mesh.von_mises = std::max(mesh.von_mises, c.max_stress.value);
    mesh.error = std::max(mesh.error, std::pow(c.energy_norm_error, 2));
    if (largest.value > 0) mesh.error = std::max(mesh.error, largest.error / largest.value);
  }
  return mesh;
}

// Observes the largest stress of each load case from mesh to mesh.
class StressConvergence {
 public:
  // Takes the results on the next mesh. Returns the largest estimated error.
  double update(const std::vector<ShellCaseResult>& cases) {
    double most = 0;
    cases_.resize(cases.size());
    for (size_t c = 0; c < cases.size(); ++c) {
      Case& of = cases_[c];
      of.name = cases[c].name;
      of.at = cases[c].max_stress.at;
      of.where = cases[c].max_stress.where;
      of.at_point_load = of.at_point_load || cases[c].near_singularity;
      const double value = cases[c].max_stress.value;
      if (!of.values.empty())
        of.increases.push_back(value > 0 ? (value - of.values.back()) / value : 0);
      of.values.push_back(value);
      of.singular = of.singular || grows_without_limit(of.increases);
      if (of.excluded() || value == 0) continue;
      of.error = cases[c].max_stress.spread / value;
      if (!of.increases.empty()) of.error = std::max(of.error, std::abs(of.increases.back()));
      most = std::max(most, of.error);
    }
    return most;
  }

  // Marks the triangles around the largest stresses whose error exceeds `accuracy`.
  void mark(const ModelLayout& layout, const Points& shape, double accuracy,
            std::vector<char>& marks) const {
    const Surface surface = layout.surface(shape);
    for (const Case& of : cases_) {
      if (of.excluded() || of.error <= accuracy) continue;
      const auto centre = [&](int t) { return surface.position({t, Vec3::Constant(1.0 / 3)}); };
      const int peak = of.where.triangle;
      const double edge =
          std::sqrt(2 * surface.mesh().shape(peak).area *
                    surface.jet({peak, Vec3::Constant(1.0 / 3)}).area_vector().norm());
      constexpr double around = 2;  // in edge lengths
      for (int t = 0; t < surface.mesh().triangle_count(); ++t)
        if ((centre(t) - of.at).norm() <= around * edge) marks[t] = 1;
    }
  }

  std::vector<RefinedShell::Singularity> singularities() const {
    std::vector<RefinedShell::Singularity> found;
    for (const Case& of : cases_)
      if (of.singular && !of.at_point_load) found.push_back({of.name, of.at});
    return found;
  }

 private:
  struct Case {
    std::string name;
    Vec3 at = Vec3::Zero();
    Location where;
    std::vector<double> values, increases;
    double error = 0;
    bool singular = false, at_point_load = false;
    bool excluded() const { return singular || at_point_load; }
  };
  static bool grows_without_limit(const std::vector<double>& increases) {
    constexpr size_t rounds = 3;
    constexpr double least = 0.02;
    if (increases.size() < rounds) return false;
    const double* last = increases.data() + increases.size() - rounds;
    return *std::min_element(last, last + rounds) > least && last[rounds - 1] > 0.5 * last[0];
  }

  std::vector<Case> cases_;
};

}  // namespace

RefinedShell refine_shell(std::shared_ptr<const ModelLayout> layout, const Points& shape,
                          const ShellProblem& problem, const ShellRefinementOptions& options,
                          const Progress& progress) {
  require_valid(options);
  RefinedShell result{layout, shape, {}, false, {}};
  StressConvergence stresses;
  VecX indicators;
  for (int round = 0; round < options.max_meshes; ++round) {
    progress.update("mesh " + std::to_string(round + 1), 0);
    try {
      std::shared_ptr<const ModelLayout> next = result.layout;
      Points dofs = result.shape;
      if (round > 0) {
        std::vector<char> marks(static_cast<size_t>(indicators.size()), 0);
        if (!(result.meshes.back().error <= options.accuracy))
          for (const int t : dorfler_marking(indicators, options.bulk_fraction)) marks[t] = 1;
        stresses.mark(*result.layout, result.shape, options.accuracy, marks);
        ModelLayout finer = *result.layout;
        finer.refine(marks);
        dofs = interpolate_onto(*result.layout, result.shape, finer);
        next = std::make_shared<const ModelLayout>(std::move(finer));
      }
      const ShellDefinition definition = problem.definition(*next, dofs);
      const ShellModel shell(*next, dofs, definition, ShellModel::RigidBodyHandling::Refused,
                             options.backend_factory);
      const std::vector<ShellCaseResult> cases = evaluate_load_cases(
          shell, problem.load_cases(*next, dofs, definition), {}, &indicators, progress);
      RefinedShell::Mesh mesh = mesh_result(cases);
      mesh.stress_error = stresses.update(cases);
      mesh.edge_length = mean_edge_length(*next, dofs);
      mesh.unknowns = shell.unknowns();
      result.meshes.push_back(mesh);
      result.layout = std::move(next);
      result.shape = std::move(dofs);
      result.singularities = stresses.singularities();
      result.converged = mesh.error <= options.accuracy && mesh.stress_error <= options.accuracy;
      if (result.converged) break;
    } catch (const MemoryError&) {
      if (round == 0) throw;  // otherwise keep the largest mesh that fits into memory
      break;
    }
  }
  return result;
}

}  // namespace batten
