#include "batten/apps/commands/shapes/stress_accuracy.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/shapes/stress_shape.h"
#include "batten/core/errors.h"
#include "batten/core/largest_share.h"
#include "batten/skinning/surfaces/embedded_joins.h"

namespace batten {
namespace {

// Of the elements of a shape.
double mean_edge(const MadeShape& shape) {
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
MadeShape halved(const MadeShape& shape, const std::vector<int>& triangles) {
  std::vector<char> marks(static_cast<size_t>(shape.layout->mesh()->triangle_count()), 0);
  for (const int t : triangles) marks[t] = 1;
  ModelLayout finer = *shape.layout;
  finer.refine(marks);
  MadeShape result = shape;
  result.dofs = carried_over(*shape.layout, shape.dofs, finer);
  result.unloaded = carried_over(*shape.layout, shape.unloaded, finer);
  result.regions.clear();
  for (int r = 0; r < finer.region_count(); ++r)
    result.regions.push_back(finer.skinned(r, result.dofs));
  result.layout = std::make_shared<const ModelLayout>(std::move(finer));
  return result;
}

}  // namespace

AccurateShape accurate_shape(const Scene& scene, const MadeShape& shape, double accuracy,
                             const FactorMaker& factors, const Progress& progress) {
  AccurateShape result{shape, {}, false};
  if (!shape.layout) return result;
  constexpr int most = 20;
  constexpr double share = 0.7;  // of the error, in the triangles that are halved
  MadeShape next = shape;
  for (int round = 0; round < most; ++round) {
    progress.at("mesh " + std::to_string(round + 1), 0);
    VecX where;
    try {
      const StressReport report = stresses_of(scene, next, where, factors, progress);
      result.meshes.push_back(mesh_of(report, mean_edge(next)));
      result.shape = next;
      result.reached = result.meshes.back().error <= accuracy;
      if (result.reached) break;
      next = halved(next, largest_share(where, share));
    } catch (const InputError&) {
      if (round == 0) throw;  // else it is what memory has room for
      break;
    }
  }
  return result;
}

}  // namespace batten
