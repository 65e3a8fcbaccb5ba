// SPDX-License-Identifier: MPL-2.0
// Curve networks: grids of increasing size, single faces with many curves compared with
// OpenCASCADE's filling, and the cost of splitting one face into 200.
// Time: processor time from the curves to the checked model, on one thread, without output; also
// wall-clock time on two threads; and 3,136 faces by the program, including files. Compared with
// OpenCASCADE's filling: from the curves to the surface only.
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "batten/core/geometry.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "bench.h"
#include "cases.h"
#include "occ_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;

struct TimedModel {
  SurfaceModel model;
  int regions = 0, triangles = 0, failed = 0;
  double network = 0, find = 0, skin = 0;
  double total() const { return network + find + skin; }
};

TimedModel make(const std::vector<CharacterLine>& lines, double edge, double crease_angle) {
  TimedModel made;
  double start = seconds();
  const CurveNetwork network(lines);
  made.network = seconds() - start;
  start = seconds();
  const FoundRegions found = find_regions(network);
  made.find = seconds() - start;
  start = seconds();
  ModelOptions options;
  options.skin.edge_length = edge;
  options.crease_angle_deg = crease_angle;
  made.model = skin_network(network, found, options);
  made.skin = seconds() - start;
  for (const ModelRegion& region : made.model.regions) {
    ++made.regions;
    if (!region.skinned)
      ++made.failed;
    else
      made.triangles += region.skinned->surface.mesh().triangle_count();
  }
  return made;
}

// A closed loop of `count` slightly bent cubics with alternating convex and concave corners: a
// gear.
std::vector<Cubic> loop(int count) {
  const auto point = [&](int i) {
    const double t = 2 * M_PI * i / count, r = i % 2 ? 1.05 : 0.85;
    return Vec3(r * std::cos(t), r * std::sin(t), 0.2 * std::cos(2 * t) + 0.05 * std::sin(5 * t));
  };
  std::vector<Cubic> curves;
  for (int i = 0; i < count; ++i) {
    const Vec3 p = point(i), q = point((i + 1) % count), chord = q - p;
    const Vec3 out = 0.03 * Vec3(-chord.y(), chord.x(), 0.3 * chord.norm());
    curves.push_back({p, p + chord / 3 + out, q - chord / 3 + out, q});
  }
  return curves;
}

std::vector<CharacterLine> lines_of(const std::vector<Cubic>& curves) {
  std::vector<CharacterLine> lines;
  for (const Cubic& c : curves)
    lines.push_back(
        {"line " + std::to_string(lines.size() + 1), bezier_curve(c[0], c[1], c[2], c[3])});
  return lines;
}

// From curves to the surface, as OpenCASCADE's filling: one face, without search for defects or
// measurements. Returns the quality of the face if `look` is set.
SkinQuality fill(const std::vector<CharacterLine>& lines, bool look = false) {
  SkinOptions options;
  options.edge_length = 0.1;
  const RegionLayout layout("region", lines, options);
  Points dofs = ModelLayout(layout).minimize_energy({});
  return look ? measure(layout.region(std::move(dofs))) : SkinQuality{};
}

// Peak memory of this process since the last call, beyond its present memory; bytes. 0 if the
// system does not provide it.
class Peak {
 public:
  Peak() {
    malloc_trim(0);  // otherwise freed memory in the heap would be reused without being counted
    if (std::FILE* f = std::fopen("/proc/self/clear_refs", "w")) {
      std::fputs("5", f);
      std::fclose(f);
    }
    start_ = now();
  }
  double grown() const { return std::max(0.0, now() - start_); }

 private:
  static double now() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.rfind("VmHWM:", 0) == 0) return 1024 * std::stod(line.substr(6));
    return 0;
  }
  double start_;
};

constexpr double kNoJoins = -1, kAllSmooth = 180;

void grids(Checks& checks) {
  Table table;
  table.add({"grid", "faces", "triangles", "network ms", "faces ms", "skin ms", "ms per face",
             "kB per face", "smooth: ms", "largest angle"});
  std::map<int, double> each, search, memory;  // per number of curves
  for (const int count : {24, 60, 200, 400}) {
    const int cells = count / 2 - 1;
    const std::vector<CharacterLine> lines = wavy_grid(cells, cells);
    const double edge = 0.25 / cells;
    const Peak peak;
    TimedModel made = make(lines, edge, kNoJoins);
    const bool correct = made.regions == cells * cells && made.failed == 0;
    const double most = correct ? 1 : std::numeric_limits<double>::infinity();
    memory[count] = most * peak.grown() / made.regions;
    each[count] = most * made.total() / made.regions;
    search[count] = most * (made.network + made.find) / made.regions;
    // A system of thousands of faces shows nothing that 841 do not.
    const bool joined = count <= 60;
    const TimedModel smooth = joined ? make(lines, edge, kAllSmooth) : TimedModel{};
    table.add({std::to_string(count) + " curves",
               std::to_string(made.regions) + (correct ? "" : " WRONG"),
               std::to_string(made.triangles), text("%.1f", 1e3 * made.network),
               text("%.1f", 1e3 * made.find), text("%.1f", 1e3 * made.skin),
               text("%.2f", 1e3 * each[count]), text("%.0f", memory[count] / 1024),
               joined ? text("%.1f", 1e3 * smooth.total()) : "",
               joined ? text("%.2g deg", smooth.model.max_join_deg) : ""});
  }
  table.print();
  checks.at_most("time per face, 200 by 200 curves over 12 by 12", each[400] / each[24], 1.3);
  checks.at_most("search per face, 200 by 200 curves over 12 by 12", search[400] / search[24], 1.3);
  checks.at_most("memory per face, 200 by 200 curves over 100 by 100",
                 memory[200] > 0 ? std::optional(memory[400] / memory[200]) : std::nullopt, 1.1);

  const std::vector<CharacterLine> lines = wavy_grid(99, 99);
  const auto all = [&] { make(lines, 0.25 / 99, kNoJoins); };
  const double one = wall_seconds_of(all);
  set_thread_count(2);
  const double two = wall_seconds_of(all);
  set_thread_count(1);
  std::printf("100 by 100 curves, wall-clock time: %.1f s on one thread, %.1f s on two.\n\n", one,
              two);
  checks.at_least("one thread's time over two threads', 100 by 100 curves", one / two, 1.6);
}

// 57 × 57 curves as a file of points through the program, with STEP, in a separate process.
void program(Checks& checks) {
#ifdef BATTEN_PROGRAM
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("batten_grid_" + std::to_string(getpid()));
  fs::create_directories(folder);
  {
    std::ofstream file(folder / "grid.csv");
    file << "x,y,z\n";
    for (const CharacterLine& line : wavy_grid(56, 56)) {
      for (int i = 0; i <= 60; ++i) {
        const double t = line.curve->start() + (line.curve->end() - line.curve->start()) * i / 60;
        const Vec3 p = line.curve->evaluate(t, 0);
        file << format_number(p.x()) << ',' << format_number(p.y()) << ',' << format_number(p.z())
             << '\n';
      }
      file << '\n';
    }
  }
  const std::string csv = (folder / "grid.csv").string(), out = (folder / "out").string();
  int status = 0;
  rusage used{};
  const double clock = wall_seconds_of([&] {
    const pid_t child = fork();
    if (child == 0) {
      std::freopen("/dev/null", "w", stdout);
      execl(BATTEN_PROGRAM, BATTEN_PROGRAM, "skin", csv.c_str(), "--unit", "m", "--out",
            out.c_str(), nullptr);
      _exit(127);
    }
    wait4(child, &status, 0, &used);
  });
  const bool correct = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  std::printf("57 by 57 curves through the program, with STEP: %.1f s, %.2f GB, exit code %d.\n\n",
              clock, used.ru_maxrss / 1048576.0, WEXITSTATUS(status));
  const auto if_correct = [&](double x) { return correct ? std::optional(x) : std::nullopt; };
  checks.at_most("seconds, 57 by 57 curves with STEP", if_correct(clock), 20);
  checks.at_most("GB, 57 by 57 curves with STEP", if_correct(used.ru_maxrss / 1048576.0), 1);
  fs::remove_all(folder);
#else
  checks.at_most("seconds, 57 by 57 curves with STEP", std::nullopt, 20);
#endif
}

}  // namespace

// With a number: only the grid of that many curves.
int main(int argc, char** argv) {
  one_thread();
  if (argc > 1) {
    const int cells = std::stoi(argv[1]) / 2 - 1;
    const TimedModel made = make(wavy_grid(cells, cells), 0.25 / cells, kNoJoins);
    std::printf("%d faces: network %.2f s, faces %.2f s, skin %.2f s\n", made.regions, made.network,
                made.find, made.skin);
    return 0;
  }
  Checks checks;
  program(checks);  // first: a child process counts the memory that its parent had
  grids(checks);

  {
    const std::string version = occ_version();
    Table table;
    table.add({"one face", "Batten ms", "OpenCASCADE ms", "ratio",
               "with search, quality and checks: ms"});
    std::vector<double> ours;
    std::optional<double> ratio;
    for (const int count : {12, 16, 20, 28}) {
      const std::vector<Cubic> curves = loop(count);
      const std::vector<CharacterLine> lines = lines_of(curves);
      std::vector<std::function<void()>> works = {[&] { fill(lines); },
                                                  [&] { make(lines, 0.1, kNoJoins); }};
      if (!version.empty()) works.push_back([&] { OccFilling(curves, {}, {"", 1e-4, 15, 9}); });
      const std::vector<double> time = side_by_side(5, works);
      const TimedModel made = make(lines, 0.1, kNoJoins);
      const bool correct =
          made.regions == 1 && made.failed == 0 && fill(lines, true).max_line_residual < 1e-10;
      ours.push_back(correct ? time[0] : std::numeric_limits<double>::infinity());
      if (time.size() > 2) ratio = time[2] / ours.back();
      table.add(
          {std::to_string(count) + " curves, " + std::to_string(made.triangles) + " triangles",
           text("%.1f", 1e3 * ours.back()), time.size() > 2 ? text("%.1f", 1e3 * time[2]) : "",
           ratio ? text("%.1f", *ratio) : "", text("%.1f", 1e3 * time[1])});
    }
    table.print();
    checks.at_least("OpenCASCADE's time over Batten's, one face of 28 curves", ratio, 5);
    checks.at_most("growth of the time from 16 to 28 curves over that of the curves",
                   ours.back() / ours[1] / (28.0 / 16), 1.3);
  }

  {
    // About 100 triangles in each of 200 cells, and as many in the single face.
    const std::vector<CharacterLine> cells = wavy_grid(20, 10), whole = wavy_grid(1, 1);
    std::vector<double> many, one;
    TimedModel a, b;
    for (int round = 0; round < 3; ++round) {
      a = make(cells, 0.0105, kNoJoins);
      b = make(whole, 0.0108, kNoJoins);
      many.push_back(a.total());
      one.push_back(b.total());
    }
    const TimedModel smooth = make(cells, 0.0105, kAllSmooth);
    Table table;
    table.add({"20,000 triangles", "faces", "triangles", "seconds", "largest angle"});
    const auto row = [&](const std::string& name, const TimedModel& m, double time) {
      table.add({name, std::to_string(m.regions), std::to_string(m.triangles), text("%.3f", time),
                 text("%.2g deg", m.model.max_join_deg)});
    };
    row("200 faces, creases", a, median(many));
    row("200 faces, smooth", smooth, smooth.total());
    row("one face", b, median(one));
    table.print();
    const bool correct = a.regions == 200 && a.failed == 0 && b.regions == 1 && b.failed == 0;
    checks.at_most("200 faces with creases over one, 20,000 triangles in total",
                   correct ? std::optional(median(many) / median(one)) : std::nullopt, 3);
  }
  checks.print("network");
}
