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

}  // namespace

RefinedShell refine_shell(std::shared_ptr<const ModelLayout> layout, const Points& shape,
                          const ShellProblem& problem, const ShellRefinementOptions& options,
                          const Progress& progress) {
  require_valid(options);
  RefinedShell result{layout, shape, {}, false};
  VecX indicators;
  for (int round = 0; round < options.max_meshes; ++round) {
    progress.update("mesh " + std::to_string(round + 1), 0);
    try {
      std::shared_ptr<const ModelLayout> next = result.layout;
      Points dofs = result.shape;
      if (round > 0) {
        std::vector<char> marks(static_cast<size_t>(indicators.size()), 0);
        for (const int t : dorfler_marking(indicators, options.bulk_fraction)) marks[t] = 1;
        ModelLayout finer = *result.layout;
        finer.refine(marks);
        dofs = interpolate_onto(*result.layout, result.shape, finer);
        next = std::make_shared<const ModelLayout>(std::move(finer));
      }
      const ShellDefinition definition = problem.definition(*next, dofs);
      const ShellModel shell(*next, dofs, definition, ShellModel::RigidBodyHandling::Refused,
                             options.backend_factory);
      RefinedShell::Mesh mesh = mesh_result(evaluate_load_cases(
          shell, problem.load_cases(*next, dofs, definition), {}, &indicators, progress));
      mesh.edge_length = mean_edge_length(*next, dofs);
      mesh.unknowns = shell.unknowns();
      result.meshes.push_back(mesh);
      result.layout = std::move(next);
      result.shape = std::move(dofs);
      result.converged = mesh.error <= options.accuracy;
      if (result.converged) break;
    } catch (const MemoryError&) {
      if (round == 0) throw;  // otherwise keep the largest mesh that fits into memory
      break;
    }
  }
  return result;
}

}  // namespace batten
