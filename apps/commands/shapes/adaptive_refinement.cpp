#include "batten/apps/commands/shapes/adaptive_refinement.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/shapes/stress_analysis.h"
#include "batten/core/dorfler_marking.h"
#include "batten/core/errors.h"
#include "batten/skinning/surfaces/embedded_joins.h"

namespace batten {
namespace {

// Of the elements of a shape.
double mean_edge(const SolvedShape& shape) {
  double area = 0, triangles = 0;
  for (const SkinnedRegion& region : shape.regions) {
    const Surface& surface = region.surface;
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
      area += surface.mesh().shape(t).area *
              surface.jet({t, Vec3::Constant(1.0 / 3)}).area_vector().norm();
      ++triangles;
    }
  }
  return std::sqrt(2 * area / triangles);
}

StressReport::Mesh mesh_of(const StressReport& report, double edge_length) {
  StressReport::Mesh mesh{edge_length, report.unknowns, 0, 0, 0};
  for (const StressReport::Case& c : report.cases) {
    mesh.displacement = std::max(mesh.displacement, c.displacement);
    mesh.stress = std::max(mesh.stress, c.stress);
    mesh.error = std::max(mesh.error, std::pow(c.error, 2));
    if (c.displacement > 0)
      mesh.error = std::max(mesh.error, c.displacement_error / c.displacement);
  }
  return mesh;
}

// The same surface on halved triangles.
SolvedShape halved(const SolvedShape& shape, const std::vector<int>& triangles) {
  std::vector<char> marks(static_cast<size_t>(shape.layout->mesh()->triangle_count()), 0);
  for (const int t : triangles) marks[t] = 1;
  ModelLayout finer = *shape.layout;
  finer.refine(marks);
  SolvedShape result = shape;
  result.dofs = interpolate_onto(*shape.layout, shape.dofs, finer);
  result.unloaded = interpolate_onto(*shape.layout, shape.unloaded, finer);
  result.regions.clear();
  for (int r = 0; r < finer.region_count(); ++r)
    result.regions.push_back(finer.skinned(r, result.dofs));
  result.layout = std::make_shared<const ModelLayout>(std::move(finer));
  return result;
}

}  // namespace

RefinedShape refine_adaptively(const Scene& scene, const SolvedShape& shape, double accuracy,
                               const BackendFactory& factors, const Progress& progress) {
  RefinedShape result{shape, {}, false};
  if (!shape.layout) return result;
  constexpr int most = 20;
  constexpr double fraction = 0.7;  // of the error, in the triangles that are halved
  SolvedShape next = shape;
  for (int round = 0; round < most; ++round) {
    progress.update("mesh " + std::to_string(round + 1), 0);
    VecX where;
    try {
      const StressReport report = stresses_of(scene, next, where, factors, progress);
      result.meshes.push_back(mesh_of(report, mean_edge(next)));
      result.shape = next;
      result.converged = result.meshes.back().error <= accuracy;
      if (result.converged) break;
      next = halved(next, dorfler_marking(where, fraction));
    } catch (const InputError&) {
      if (round == 0) throw;  // else it is what memory has room for
      break;
    }
  }
  return result;
}

}  // namespace batten
