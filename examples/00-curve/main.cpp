// SPDX-License-Identifier: MPL-2.0
// Automatic fairing: computes the smooth curve behind noisy points.
//
// 1. points along a known spiral, each with an error of up to 0.3 mm
// 2. as given: the C2 curve through all points
// 3. fair: the smoothing spline, with the noise estimated by cross-validation
// 4. comparison of both curves with the spiral; files for CAD and ParaView, and a picture if there
//    is a display
//
// Usage: curve [OUTPUT FOLDER]
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <random>

#include "batten/fairing/curves/fair_curve.h"
#include "batten/io/lines/curve_files.h"
#include "batten/io/pictures/comb_pictures.h"

namespace {

using namespace batten;

double off_spiral(const HermiteCurve& curve, const std::vector<Vec3>& spiral) {
  double squares = 0;
  for (const Vec3& p : spiral) squares += std::pow(curve.closest_point(p).distance, 2);
  return std::sqrt(squares / static_cast<double>(spiral.size()));
}

int run(const std::filesystem::path& out) {
  // 1. Lengths are in millimetres. The noise is the same on every machine.
  std::mt19937 hand;
  std::vector<Vec3> spiral, points;
  for (int i = 0; i <= 160; ++i) {
    const double t = 4.0 * i / 160, r = 40 * std::exp(0.2 * t);
    const double noise = 0.3 * (2.0 * static_cast<double>(hand()) / std::mt19937::max() - 1);
    const Vec3 radial(std::cos(t), std::sin(t), 0);
    spiral.push_back(r * radial);
    points.push_back((r + noise) * radial);
  }

  // 2. The curve as given.
  const HermiteCurve given = interpolating_spline("spiral", points);

  // 3. Constraints (points, directions, planes) could be set in the options.
  const FairCurve fair = fair_points("spiral", points);

  // 4. Comparison and output.
  const Fairness before = fairness(given), after = fairness(fair.curve);
  const double noise = off_spiral(given, spiral), left = off_spiral(fair.curve, spiral);
  std::filesystem::create_directories(out);
  write_curves(out / "spiral.step", {{"spiral", fair.curve, fair.parameters, {}}});
  write_curves(out / "spiral.vtp", {{"spiral", fair.curve, fair.parameters, {}}});
  CombPicture picture;
  picture.panels = {{"as given", {given}, points, {}}, {"fair", {fair.curve}, points, {}}};
  picture.unit = "mm";
  picture.scale_panel = 1;
  draw_combs(out / "curve.png", picture);
  std::printf("off the spiral (rms)  %.3f mm as given, %.3f mm fair\n", noise, left);
  std::printf("bending               %.3g as given, %.3g fair (1/mm)\n", before.bending,
              after.bending);
  std::printf("inflections           %d as given, %d fair\n", before.inflections,
              after.inflections);
  std::printf("smoothed              waves under %.0f mm, in %d rounds\n", fair.wavelength,
              fair.rounds);
  std::printf("spiral.step, .vtp in  %s\n", out.c_str());
  return left < 0.5 * noise && after.inflections == 0 ? 0 : 4;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : "out/00-curve");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "curve: %s\n", e.what());
    return 1;
  }
}
