// SPDX-License-Identifier: MPL-2.0
// A surface over a loop of cubics: Batten's skin compared with OpenCASCADE's filling.
// Two faces: a curved pentagon, and a four-sided patch with one inner cubic. Time: from the curves
// to the surface, including meshing. Distance: the largest one from a point of a curve to the
// resulting surface, and from a point of the surface's edge to the closest curve.
#include <algorithm>
#include <cmath>

#include "batten/constraints/constrained_solver.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/layout/region_layout.h"
#include "batten/skinning/region/skinned_region.h"
#include "bench.h"
#include "cases.h"
#include "occ_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;

constexpr int rounds = 7, samples_a_curve = 200;

std::vector<Cubic> all_curves(const CurvedLoop& c) {
  std::vector<Cubic> curves = c.outline;
  curves.insert(curves.end(), c.inner.begin(), c.inner.end());
  return curves;
}

SkinnedRegion skin(const CurvedLoop& c) {
  SkinOptions options;
  options.edge_length = c.edge_length;
  const RegionLayout layout(c.name, lines_of(c), options);
  const SurfaceAssembler assembler(*layout.mesh(), layout.element());
  const ConstrainedSolver solver(layout.line_constraints(),
                                 assembler.stiffness(SurfaceStiffness::isotropic(0, 1)),
                                 nested_dissection_order(*layout.mesh()));
  return layout.region(solver.solve(Points::Zero(assembler.dofs().count(), 3)));
}

// Distance from p to a cubic: the best of many samples, refined by Newton's method.
double distance_to(const Cubic& c, const Vec3& p) {
  constexpr int samples = 64;
  double best = 0, nearest = 1e100;
  for (int k = 0; k <= samples; ++k) {
    const double t = static_cast<double>(k) / samples, d = (cubic_point(c, t) - p).norm();
    if (d < nearest) {
      nearest = d;
      best = t;
    }
  }
  double t = best;
  for (int i = 0; i < 8; ++i) {
    const double s = 1 - t;
    const Vec3 first =
        3 * (s * s * (c[1] - c[0]) + 2 * s * t * (c[2] - c[1]) + t * t * (c[3] - c[2]));
    const Vec3 second = 6 * (s * (c[2] - 2 * c[1] + c[0]) + t * (c[3] - 2 * c[2] + c[1]));
    const Vec3 away = cubic_point(c, t) - p;
    t = std::clamp(t - away.dot(first) / (first.squaredNorm() + away.dot(second)), 0.0, 1.0);
    nearest = std::min(nearest, (cubic_point(c, t) - p).norm());
  }
  return nearest;
}

double distance_to(const std::vector<Cubic>& curves, const Vec3& p) {
  double nearest = 1e100;
  for (const Cubic& c : curves) nearest = std::min(nearest, distance_to(c, p));
  return nearest;
}

double largest_distance(const std::vector<Cubic>& curves,
                        const std::function<double(const Vec3&)>& to_surface,
                        const std::vector<Vec3>& on_surface) {
  double largest = 0;
  for (const Cubic& c : curves)
    for (int k = 0; k <= samples_a_curve; ++k)
      largest =
          std::max(largest, to_surface(cubic_point(c, static_cast<double>(k) / samples_a_curve)));
  for (const Vec3& p : on_surface) largest = std::max(largest, distance_to(curves, p));
  return largest;
}

// Along its curves the surface's element edges are cubics: their control points from four positions
// of the surface each, and points between these for the check.
struct SurfaceLines {
  std::vector<Cubic> edges;
  std::vector<Vec3> points;
};
SurfaceLines surface_lines(const SkinnedRegion& region) {
  const ParametricMesh& mesh = region.surface.mesh();
  SurfaceLines lines;
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned)
    for (const int e : aligned_line.edges) {
      const auto& edge = mesh.edges()[e];
      const auto at = [&](double f) {
        Location where{edge.triangle[0], Vec3::Zero()};
        where.L[(edge.local[0] + 1) % 3] = 1 - f;
        where.L[(edge.local[0] + 2) % 3] = f;
        return region.surface.position(where);
      };
      const Vec3 x[] = {at(0), at(1.0 / 3), at(2.0 / 3), at(1)};
      lines.edges.push_back({x[0], (-5 * x[0] + 18 * x[1] - 9 * x[2] + 2 * x[3]) / 6,
                             (2 * x[0] - 9 * x[1] + 18 * x[2] - 5 * x[3]) / 6, x[3]});
      for (const double f : {0.0, 0.17, 0.5, 0.81, 1.0}) lines.points.push_back(at(f));
    }
  return lines;
}

}  // namespace

int main() {
  one_thread();
  const std::string version = occ_version();
  if (version.empty())
    std::printf("OpenCASCADE is missing from this build: its checks fail.\n\n");
  else
    std::printf("OpenCASCADE %s. Processor time on one thread, medians.\n\n", version.c_str());

  std::vector<OccFillingSettings> settings;
  if (!version.empty())
    settings = {{"OpenCASCADE 1e-3", 1e-3, 15, 9},
                {"OpenCASCADE 1e-4", 1e-4, 15, 9},
                {"OpenCASCADE 1e-5", 1e-5, 15, 9},
                {"OpenCASCADE 1e-5, 60 segments", 1e-5, 15, 60},
                {"OpenCASCADE 1e-5, 60 segments, 60 points", 1e-5, 60, 60}};

  Checks checks;
  for (const CurvedLoop& c : {pentagon(), patch()}) {
    const std::vector<Cubic> curves = all_curves(c);
    std::vector<std::function<void()>> works = {[&] { skin(c); }};
    for (const OccFillingSettings& s : settings)
      works.push_back([&c, &s] { OccFilling(c.outline, c.inner, s); });
    const std::vector<double> time = side_by_side(rounds, works);

    const SkinnedRegion region = skin(c);
    const int triangles = region.surface.mesh().triangle_count();
    const SurfaceLines lines = surface_lines(region);
    const double ours = largest_distance(
        curves, [&](const Vec3& p) { return distance_to(lines.edges, p); }, lines.points);
    const SkinQuality quality = measure(region);

    Table table;
    table.add({c.name, "milliseconds", "largest distance"});
    table.add({"Batten, " + std::to_string(triangles) + " triangles", text("%.1f", 1e3 * time[0]),
               text("%.2g", std::max(ours, quality.max_line_deviation))});
    std::optional<double> accurate, accurate_time;
    for (size_t s = 0; s < settings.size(); ++s) {
      const OccFilling filling(c.outline, c.inner, settings[s]);
      std::string reached = "failed";
      if (filling.done()) {
        const double distance = largest_distance(
            curves, [&](const Vec3& p) { return filling.distance(p); },
            filling.boundary_points(samples_a_curve));
        reached = text("%.2g", distance);
        if (!accurate || distance < *accurate) {
          accurate = distance;
          accurate_time = time[s + 1];
        }
      }
      table.add({settings[s].name, text("%.1f", 1e3 * time[s + 1]), reached});
    }
    table.print();
    std::printf(
        "Batten: largest jump of inner normals %.1e degrees, smallest Jacobian %.2f of the "
        "median.\n\n",
        quality.max_normal_jump_deg, quality.min_jacobian_ratio);

    checks.at_least(c.name + ": triangles", triangles, 1000);
    checks.at_most(c.name + ": largest distance from the curves",
                   std::max(ours, quality.max_line_deviation), 1e-10);
    const auto sixty = std::find_if(settings.begin(), settings.end(), [](const auto& s) {
      return s.tolerance == 1e-5 && s.max_segments == 60;
    });
    checks.at_most(c.name + ": time over OpenCASCADE's at 1e-5 with 60 segments",
                   sixty != settings.end()
                       ? std::optional(time[0] / time[1 + (sixty - settings.begin())])
                       : std::nullopt,
                   1);
    checks.at_most(c.name + ": time over OpenCASCADE's at its most accurate setting",
                   accurate_time ? std::optional(time[0] / *accurate_time) : std::nullopt, 1);
  }
  checks.print("fill");
}
