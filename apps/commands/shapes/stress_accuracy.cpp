#include "batten/apps/commands/shapes/stress_accuracy.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/shapes/stress_shape.h"

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

}  // namespace

AccurateScene accurate_scene(const Scene& scene, double accuracy, const Progress& progress) {
  AccurateScene result{scene, {}, false};
  const auto lines = faired_lines(scene, progress).lines;
  Scene next = scene;
  constexpr int most = 6;
  while (static_cast<int>(result.meshes.size()) < most) {
    StressReport report;
    double edge = next.skin.options.edge_length;
    try {
      const MadeModel made = make_model(next, lines, progress);
      const MadeShape shape = make_refined_shape(made, next, progress);
      if (!shape.layout) break;
      if (!(edge > 0)) edge = mean_edge(shape);
      report = stresses_of(next, shape, progress);
    } catch (const InputError&) {
      if (result.meshes.empty()) throw;  // else it is what memory has room for
      break;
    }
    result.scene = next;
    result.meshes.push_back(mesh_of(report, edge));
    const double error = result.meshes.back().error;
    result.reached = error <= accuracy;
    if (result.reached) break;
    // The error of displacements goes with the fourth power of the edges, beside corners and point
    // loads with a lower one.
    const double wanted = 0.9 * std::pow(accuracy / error, 0.25);
    next.skin.options.edge_length = edge * std::clamp(wanted, 0.5, 0.8);
  }
  return result;
}

}  // namespace batten
