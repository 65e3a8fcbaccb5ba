// A curve that fairs itself: points from an unsteady hand become the line that was meant.
//
// 1. points along a known spiral, each off it by up to a third of a millimetre
// 2. as given: the C2 curve through all of them
// 3. fair: no number is given, the points say how much of them is noise
// 4. both beside the spiral; files for CAD and ParaView, and a picture where there is a display
//
// Usage: curve [OUTPUT FOLDER]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <random>

#include "batten/fairing/curves/fair_curve.h"
#include "batten/fairing/curves/fairness.h"
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
  // 1. Millimetres. The noise repeats on every machine.
  std::mt19937 hand;
  std::vector<Vec3> spiral, points;
  for (int i = 0; i <= 160; ++i) {
    const double t = 4.0 * i / 160, r = 40 * std::exp(0.2 * t);
    const double noise = 0.3 * (2.0 * static_cast<double>(hand()) / std::mt19937::max() - 1);
    const Vec3 radial(std::cos(t), std::sin(t), 0);
    spiral.push_back(r * radial);
    points.push_back((r + noise) * radial);
  }

  // 2.
  const HermiteCurve given = interpolating_spline("spiral", points);

  // 3. Conditions (points, directions, planes that must hold) would go into the options.
  const FairCurve fair = fair_points("spiral", points);

  // 4.
  const Fairness before = fairness(given), after = fairness(fair.curve);
  const double noise = off_spiral(given, spiral), left = off_spiral(fair.curve, spiral);
  std::filesystem::create_directories(out);
  write_curves(out / "spiral.step", {{"spiral", fair.curve, fair.parameters, {}}});
  write_curves(out / "spiral.vtp", {{"spiral", fair.curve, fair.parameters, {}}});
  if (std::getenv("DISPLAY")) {
    CombPicture picture;
    picture.panels = {{"as given", {given}, points, {}}, {"fair", {fair.curve}, points, {}}};
    picture.unit = "mm";
    picture.scale_panel = 1;
    draw_combs(out / "curve.png", picture);
  }
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
