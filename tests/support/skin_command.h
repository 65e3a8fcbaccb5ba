// SPDX-License-Identifier: MPL-2.0
// `batten skin curves.csv` in the test process: the same calls, and the resulting shape as facets.
#pragma once

#include "batten/core/errors.h"
#include "batten/scenes/commands.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/skinning/facets/facets.h"
#include "batten/tests/support/expected_shapes.h"

namespace batten_test {

/// Result of the command for one file of curves.
struct SkinnedCurves {
  int exit_code = 0;
  std::string message;  ///< of the error, or the failed checks, or ""
  batten::Report report;
  std::optional<batten::BuiltModel> made;  ///< none after an error
  std::optional<FacetedSurface> facets;    ///< of all faces, as in the VTP file
  double area = 0, volume = 0;             ///< exact, of all faces; of all closed shells

  /// Whether the command reports that the result may not be as intended: by its exit code, a
  /// warning, or a remark on how it interpreted the points.
  bool warns() const {
    return exit_code != 0 || !report.warnings.empty() || !report.reading_notes.empty();
  }
};

/// Facets of all skinned faces; n² per triangle of the mesh.
inline FacetedSurface facets_of(const std::vector<batten::SkinnedRegion>& regions, int n) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> all;
  for (const batten::SkinnedRegion& region : regions) {
    const batten::Tessellation t = batten::facets(region, n).tessellation;
    const int first = static_cast<int>(points.size());
    for (const batten::Location& where : t.points) points.push_back(region.surface.position(where));
    for (const auto& [a, b, c] : t.facets) all.push_back({first + a, first + b, first + c});
  }
  return {std::move(points), all};
}

/// Runs the command without writing files other than the STEP file, in an empty folder. `step`:
/// writes and checks the STEP file as the command does; without it, the exit code does not include
/// the checks of that file.
inline SkinnedCurves skin_curves(const std::filesystem::path& csv,
                                 const std::filesystem::path& folder, bool step) {
  using namespace batten;
  SkinnedCurves result;
  try {
    Scene scene = scene_of_lines({csv}, {}, "mm");
    scene.vtp.clear();
    if (!step) scene.step.clear();
    RunContext run(scene, folder);
    result.made = model_of(run, scene, {});
    const SolvedShape shape = solve_refined_shape(*result.made, scene);
    measure_into(run, *result.made, shape, scene, {});
    if (step) write_step_file(run, scene, *result.made, {});
    run.finish({});
    result.report = run.report;
    result.facets = facets_of(shape.regions, 4);
    for (const SkinnedRegion& region : shape.regions) result.area += region.surface.area();
    for (const ModelShell& shell : result.made->model.shells)
      if (shell.closed) result.volume += std::abs(shell.volume);
    for (const FailedCheck& failed_checks : run.report.failed_checks)
      result.message += failed_checks.what + " " + failed_checks.detail + "\n";
    result.exit_code = run.report.failed_checks.empty() ? 0 : 4;
  } catch (const ConflictError& e) {
    result.exit_code = 2;
    result.message = e.what();
  } catch (const NoSolutionError& e) {
    result.exit_code = 3;
    result.message = e.what();
  } catch (const Error& e) {
    result.exit_code = 1;
    result.message = e.what();
  }
  if (result.exit_code != 0 && result.exit_code != 4) result.made.reset();
  return result;
}

/// ShapeDeviation of a result from the expected surface.
struct ShapeDeviation {
  double max = 0;     ///< largest distance in both directions, as a fraction of the size
  double area = 1;    ///< relative to the expected one, if known
  double volume = 1;  ///< likewise
  bool correct = false;
};

inline ShapeDeviation deviation_of(const SkinnedCurves& result, const ExpectedShape& shape) {
  ShapeDeviation d;
  if (!result.facets) return d;
  for (const Vec3& p : shape.samples(12)) d.max = std::max(d.max, result.facets->distance(p));
  // A sufficient number of points to detect unexpected faces and bulges.
  const auto& points = result.facets->points();
  const size_t stride = std::max<size_t>(1, points.size() / 500);
  for (size_t i = 0; i < points.size(); i += stride)
    d.max = std::max(d.max, shape.distance(points[i]));
  d.max /= shape.size();
  if (shape.area) d.area = result.area / *shape.area;
  if (shape.volume) d.volume = result.volume / *shape.volume;
  // Facets between points of the surface are inside of it.
  constexpr double facet = 2e-4;
  const double measure = 3 * shape.tolerance + 1e-6;
  d.correct = d.max <= shape.tolerance + (shape.tolerance > 1e-5 ? facet : 0) &&
              std::abs(d.area - 1) <= measure && std::abs(d.volume - 1) <= measure;
  return d;
}

}  // namespace batten_test
