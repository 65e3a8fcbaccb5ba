// SPDX-License-Identifier: MPL-2.0
// A ship's hull from a formula, with the kernel only: all steps from curves to files in one main.
//
// Wigley's hull:  y = B/2 (1 - (2x/L)²) (1 - (z/T)²),  -L/2 ≤ x ≤ L/2,  -T ≤ z ≤ 0
//
// 1. curves from the formula: keel, stems, deck edge, and waterlines from stern to bow
// 2. layout: a flat domain and its mesh, with every curve aligned with element edges
// 3. the surface of least bending energy through all curves
// 4. its distance from the formula; STEP and VTK files, and a picture if there is a display
//
// Usage: hull [OUTPUT FOLDER] [NUMBER OF WATERLINES]
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>

#include "batten/io/pictures/pictures.h"
#include "batten/io/step/step.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/region/skinned_region.h"

namespace {

using namespace batten;

constexpr double L = 10, B = 1, T = 0.625;  // metres

double half_breadth(double x, double z) {
  return B / 2 * (1 - 4 * x * x / (L * L)) * (1 - z * z / (T * T));
}

// 1. A curve along x at height z, from one end to the other. stem() is the straight stem at x,
// between keel and deck.
std::shared_ptr<const InputCurve> lengthwise(double z, bool forward) {
  return curve_from_formula(0, 1, [=](double t, int order) -> Vec3 {
    const double sign = forward ? 1 : -1, x = sign * L * (t - 0.5), dx = sign * L;
    const double fullness = B / 2 * (1 - z * z / (T * T));
    if (order == 0) return {x, half_breadth(x, z), z};
    if (order == 1) return {dx, fullness * -8 * x / (L * L) * dx, 0};
    return {0, fullness * -8 / (L * L) * dx * dx, 0};
  });
}

std::shared_ptr<const InputCurve> stem(double x, bool upward) {
  return curve_from_formula(0, 1, [=](double t, int order) -> Vec3 {
    if (order == 0) return {x, 0, upward ? -T * (1 - t) : -T * t};
    return {0, 0, order == 1 ? (upward ? T : -T) : 0};
  });
}

int run(const std::filesystem::path& out, int waterlines) {
  std::vector<CharacterLine> lines = {{"deck edge", lengthwise(0, false)},
                                      {"stern", stem(-L / 2, false)},
                                      {"keel", lengthwise(-T, true)},
                                      {"bow", stem(L / 2, true)}};
  for (int i = 1; i <= waterlines; ++i)
    lines.push_back({"waterline " + std::to_string(i), lengthwise(-T * i / (waterlines + 1), true),
                     CharacterLine::Role::Inner});

  // 2. Layout.
  SkinOptions options;
  options.tolerance = 1e-4;
  options.edge_length = 0.2;
  const RegionLayout layout("wigley", lines, options);

  // 3. Solve.
  const SculptResult shape = sculpt(layout, {});
  const SkinnedRegion hull = layout.region(shape.dofs);

  // 4. Measurement and output.
  const SkinQuality quality = measure(hull);
  double worst = 0, squares = 0;
  const Tessellation points = tessellate(hull.surface.mesh(), 4);
  for (const Location& where : points.points) {
    const Vec3 p = hull.surface.position(where);
    const double off = p.y() - half_breadth(p.x(), p.z());
    worst = std::max(worst, std::abs(off));
    squares += off * off;
  }
  std::filesystem::create_directories(out);
  write_step(out / "hull.step", {&hull}, 1.0, {});
  write_vtp(out / "hull.vtp", {&hull});

  PictureScene picture;
  picture.regions = {&hull};
  picture.contours = 8;
  picture.contour_direction = Vec3::UnitY();
  picture.azimuth = 228;
  picture.elevation = 24;
  picture.title = "Wigley's hull: contours of equal half-breadth";
  draw_picture(out / "hull.png", picture);

  std::printf("%d triangles, %d dofs per coordinate\n", hull.surface.mesh().triangle_count(),
              hull.surface.dof_map().count());
  std::printf("surface to fitted curves  %.2g of the size\n", quality.max_line_residual);
  std::printf("surface to input curves   %.2g m (tolerance %.2g m)\n", quality.max_line_deviation,
              options.tolerance);
  std::printf("surface to the formula    max %.3g m, rms %.3g m, with %d waterlines\n", worst,
              std::sqrt(squares / static_cast<double>(points.points.size())), waterlines);
  std::printf("hull.step, hull.vtp in    %s\n", out.c_str());
  return quality.max_line_deviation <= options.tolerance ? 0 : 4;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : "out/03-hull", argc > 2 ? std::atoi(argv[2]) : 2);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "hull: %s\n", e.what());
    return 1;
  }
}
