// SPDX-License-Identifier: MPL-2.0
// Overhead of Python in a drag: set three numbers, update, get the points, through the package and
// in C++.
// Both build the session of one scene and drag its fixed point to the same targets, in alternating
// processes; medians of events, one thread, processor time.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "batten/io/scene/scene.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/shapes/make_session.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;

constexpr int events = 201, warm = 20;

std::string scene_text(double edge_length) {
  return text(R"(unit = "m"

[mesh]
edge_length = %g
[[curve]]
name = "front"
points = [[0, 0, 0], [0.5, 0, 0.2], [1, 0, 0]]
[[curve]]
name = "right"
points = [[1, 0, 0], [1, 0.5, 0.1], [1, 1, 0]]
[[curve]]
name = "back"
points = [[1, 1, 0], [0.5, 1, 0.2], [0, 1, 0]]
[[curve]]
name = "left"
points = [[0, 1, 0], [0, 0.5, 0.1], [0, 0, 0]]
[[constraint]]
name = "pin"
type = "point"
at = [0.43, 0.57, 0.1]
to = [0.43, 0.57, 0.12]
)",
              edge_length);
}

/// A session in C++, and the frames that a viewer would take.
struct CppSession {
  explicit CppSession(const Scene& of)
      : scene(of),
        model(sculpt_model(build_model(scene, faired_lines(scene, {}).lines), scene)),
        session(make_session(*model.layout, scene, model.made, FactorReuse::many)) {
    session.solve_to_equilibrium();
  }
  /// Median seconds per event.
  double drag() {
    std::vector<double> times;
    for (int k = -warm; k < events; ++k) {
      const double t = cpu_seconds_of([&] {
        session.set("pin.x", 0.43 + 1e-4 * (k % 7));
        session.set("pin.y", 0.57 + 1e-4 * (k % 5));
        session.set("pin.z", 0.12 + 1e-3 * (k % 11));
        session.solve_preview();
        session.draw(frames.writing());
        frames.publish();
      });
      if (k >= 0) times.push_back(t);
    }
    return median(times);
  }
  Scene scene;
  SculptModel model;
  SculptingSession session;
  FrameExchange frames;
};

/// The same drag in Python: time, and position of the last point; none if it did not run.
std::optional<std::array<double, 2>> in_python(const std::string& scene) {
  const std::string command = std::string("PYTHONPATH='") + BATTEN_PACKAGE + "' '" + BATTEN_PYTHON +
                              "' '" + BATTEN_DRAG_PY + "' '" + scene + "' " + text("%d", events) +
                              " " + text("%d", warm);
  const std::unique_ptr<FILE, int (*)(FILE*)> run(popen(command.c_str(), "r"), pclose);
  std::array<double, 2> found{};
  if (!run || std::fscanf(run.get(), "%lf %lf", &found[0], &found[1]) != 2) return {};
  return found;
}

}  // namespace

int main() {
  one_thread();
  Table table;
  Checks checks;
  table.add({"unknowns", "points", "C++ ms", "Python ms", "overhead"});
  for (const double edge_length : {0.06, 0.0225}) {
    const std::string file = text("/tmp/batten_bench_python_%g.toml", edge_length);
    if (FILE* out = std::fopen(file.c_str(), "w")) {
      std::fputs(scene_text(edge_length).c_str(), out);
      std::fclose(out);
    }
    CppSession cpp(read_scene(file));
    std::vector<double> ours, theirs;
    bool same = true;
    for (int round = 0; round < 7; ++round) {
      ours.push_back(cpp.drag());
      const auto python = in_python(file);
      if (!python) continue;
      theirs.push_back((*python)[0]);
      const Frame& frame = cpp.session.frame();
      double sum = 0;
      for (const float x : frame.points) sum += static_cast<double>(x);
      if (round == 0) same = sum == (*python)[1];
    }
    std::remove(file.c_str());
    const double c = median(ours);
    std::optional<double> more;
    if (!theirs.empty()) more = median(theirs) / c - 1;
    table.add({text("%ld", static_cast<long>(cpp.session.dofs().rows())),
               text("%zu", cpp.session.frame().points.size() / 3), text("%.3f", 1e3 * c),
               theirs.empty() ? "none" : text("%.3f", 1e3 * median(theirs)),
               more ? text("%.1f %%", 100 * *more) : "none"});
    const std::string name =
        text("%ldk", (static_cast<long>(cpp.session.dofs().rows()) + 500) / 1000);
    checks.at_most(name + ": sums of coordinates that differ", same && more ? 0. : 1., 0);
    if (edge_length < 0.05)
      checks.at_most(name + ": overhead of a drag in Python over C++", more, 0.1);
  }
  table.print();
  checks.print("python");
}
