// SPDX-License-Identifier: MPL-2.0
// An interactive sculpting session in C++, with a viewer in a second thread.
//
// 1. layout: a roof over four arched edges, with a rib inside
// 2. session: a pressure, an offset that lifts the rib, a point constraint; one slider drives the
//    first two
// 3. one thread drags and publishes frames; another one reads the newest frame, as a window would
// 4. timing; undo; files, and a picture if there is a display
//
// Usage: drag [OUTPUT FOLDER] [EDGE LENGTH]
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <numbers>
#include <thread>

#include "batten/io/pictures/pictures.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/sculpting/session/sculpting_session.h"

namespace {

using namespace batten;
using Clock = std::chrono::steady_clock;

// 1. Lengths are in metres. The outline is counter-clockwise seen from above: the normal points up.
RegionLayout roof(double edge_length) {
  const Vec3 corner[] = {{0, 0, 0}, {6, 0, 0}, {6, 4, 0}, {0, 4, 0}};
  const double rise[] = {0.9, 0.4, 0.9, 0.4};
  std::vector<CharacterLine> lines;
  for (int i = 0; i < 4; ++i) {
    const Vec3 a = corner[i], b = corner[(i + 1) % 4], up(0, 0, 4.0 / 3 * rise[i]);
    lines.push_back({"edge " + std::to_string(i + 1),
                     bezier_curve(a, a + (b - a) / 3 + up, b - (b - a) / 3 + up, b)});
  }
  CharacterLine rib{
      "rib", bezier_curve({1.2, 2, 0.85}, {2.4, 2.3, 1.15}, {3.6, 2.3, 1.15}, {4.8, 2, 0.85})};
  rib.role = CharacterLine::Role::Inner;
  lines.push_back(rib);
  SkinOptions options;
  options.edge_length = edge_length;
  return {"roof", lines, options};
}

int run(const std::filesystem::path& out, double edge_length) {
  // 2. With the value 0, load and offset do not change the shape.
  SculptingSession session(roof(edge_length), {});
  const SkinnedRegion before = session.region();
  session.add(Load{"swell", Load::Pressure{}}, {{.name = "swell", .min = -200, .max = 200}});
  session.add(LineOffset{"ridge", "rib", Vec3::UnitZ()}, {{.name = "ridge", .min = 0, .max = 1}});
  // Fixes the point of the roof nearest to `at` at its goal (parameters nail.x, nail.y, nail.z).
  session.add(Constraint{"nail", Constraint::Point{{1.5, 1, 0.8}, {1.5, 1, 0.9}}});
  session.add_parameter({.name = "fuller", .min = 0, .max = 1});
  session.set_rule("swell", {{"fuller", 120}}, 0);
  session.set_rule("ridge", {{"fuller", 0.35}}, 0);

  // 3. The viewer thread, then the drag.
  FrameExchange frames;
  std::atomic<bool> done{false};
  long seen = 0;
  float highest = 0;
  std::thread viewer([&] {
    while (!done) {
      if (const Frame* frame = frames.latest()) {
        ++seen;
        for (size_t i = 2; i < frame->points.size(); i += 3)
          highest = std::max(highest, frame->points[i]);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  const int fuller = session.parameters().index("fuller"),
            up = session.parameters().index("nail.z");
  constexpr int updates = 300;
  int iterations = 0;
  double worst = 0;
  const auto start = Clock::now();
  for (int i = 0; i <= updates; ++i) {
    const double t = static_cast<double>(i) / updates;
    session.set(fuller, 0.5 - 0.5 * std::cos(3 * std::numbers::pi * t));
    session.set(up, 0.9 + 0.3 * std::sin(2 * std::numbers::pi * t));
    iterations += session.solve_preview().iterations;
    worst = std::max(worst, session.residual());
    session.draw(frames.writing());
    frames.publish();
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  session.solve_to_equilibrium();
  done = true;
  viewer.join();

  // 4. Results and output.
  const SkinnedRegion after = session.region();
  std::filesystem::create_directories(out);
  write_vtp(out / "roof.vtp", {&after});
  PictureScene picture;
  picture.contours = 16;
  picture.azimuth = -25;
  picture.elevation = 28;
  PictureScene second = picture;
  picture.regions = {&before};
  picture.title = "from the curves alone";
  second.regions = {&after};
  second.title = "fuller = 1, with the point constraint";
  draw_contact_sheet(out / "roof.png", {picture, second}, 2, {1500, 560});
  std::printf(
      "%d triangles: %.0f updates per second, %.1f solves each; the viewer read %ld frames\n",
      after.surface.mesh().triangle_count(), updates / seconds,
      static_cast<double>(iterations) / updates, seen);
  std::printf("constraint residual at most %.1g of the size; highest point %.3f m\n", worst,
              static_cast<double>(highest));
  const Points last = session.dofs();
  session.undo();  // reverts the whole drag
  const bool taken_back = session.parameters().value("fuller") == 0;
  session.redo();
  const bool same = taken_back && session.dofs() == last;
  std::printf("undo and redo of the drag: %s\n", same ? "bit-identical" : "NOT identical");
  std::printf("roof.vtp in %s\n", out.c_str());
  return worst <= 1e-10 && same ? 0 : 4;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : "out/13-drag", argc > 2 ? std::atof(argv[2]) : 0.2);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "drag: %s\n", e.what());
    return 1;
  }
}
