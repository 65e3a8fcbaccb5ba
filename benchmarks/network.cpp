// Networks of lines: grids of more and more lines, single regions of many lines beside
// OpenCASCADE's filling, and what cutting one region into 200 costs.
//
// Time: processor time from the lines to the model, measured and looked through for flaws, on one
// thread, nothing written. Beside OpenCASCADE's filling: from the curves to the surface only.
#include <cmath>
#include <cstdio>

#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "bench.h"
#include "cases.h"
#include "occ_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;

struct Made {
  SurfaceModel model;
  int regions = 0, triangles = 0, failed = 0;
  double network = 0, find = 0, skin = 0;
  double total() const { return network + find + skin; }
};

Made make(const std::vector<CharacterLine>& lines, double edge, double smooth_below) {
  Made made;
  double start = seconds();
  const CharacterLineNetwork network(lines);
  made.network = seconds() - start;
  start = seconds();
  const FoundRegions found = find_regions(network);
  made.find = seconds() - start;
  start = seconds();
  ModelOptions options;
  options.skin.edge_length = edge;
  options.smooth_below_deg = smooth_below;
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

// A closed row of `count` cubics, slightly bent, with corners in and out by turns: a gear.
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

// From curves to the surface, as OpenCASCADE's filling goes: one region, nothing looked for or
// measured. Returns the region's quality when `look`.
SkinQuality fill(const std::vector<CharacterLine>& lines, bool look = false) {
  SkinOptions options;
  options.edge_length = 0.1;
  const RegionLayout layout("region", lines, options);
  Points dofs = ModelLayout(layout).least_energy({});
  return look ? measure(layout.region(std::move(dofs))) : SkinQuality{};
}

}  // namespace

int main() {
  one_thread();
  Promises promises;
  constexpr double no_joins = -1, all_smooth = 180;

  {
    Table table;
    table.add({"grid", "regions", "triangles", "network ms", "regions ms", "skin ms", "ms a region",
               "smooth: ms", "largest angle"});
    double first = 0, last = 0;
    for (const int count : {12, 28, 60, 200}) {
      const int cells = count / 2 - 1;
      const std::vector<CharacterLine> lines = wavy_grid(cells, cells);
      const double edge = 0.25 / cells;
      const Made made = make(lines, edge, no_joins);
      const bool right = made.regions == cells * cells && made.failed == 0;
      const double each = made.total() / made.regions;
      if (first == 0) first = each;
      last = each;
      // 10,000 regions in one system show nothing that 841 do not.
      const bool joined = count <= 60;
      const Made smooth = joined ? make(lines, edge, all_smooth) : Made{};
      table.add({std::to_string(count) + " lines",
                 std::to_string(made.regions) + (right ? "" : " WRONG"),
                 std::to_string(made.triangles), text("%.1f", 1e3 * made.network),
                 text("%.1f", 1e3 * made.find), text("%.1f", 1e3 * made.skin),
                 text("%.2f", 1e3 * each), joined ? text("%.1f", 1e3 * smooth.total()) : "",
                 joined ? text("%.2g deg", smooth.model.max_join_deg) : ""});
      if (!right) last = std::numeric_limits<double>::infinity();
    }
    table.print();
    promises.at_most("time a region of a grid of 200 lines over that of 12", last / first, 1.5);
  }

  {
    const std::string version = occ_version();
    Table table;
    table.add(
        {"one region", "Batten ms", "OpenCASCADE ms", "ratio", "found, measured, checked: ms"});
    std::vector<double> ours;
    std::optional<double> ratio;
    for (const int count : {12, 16, 20, 28}) {
      const std::vector<Cubic> curves = loop(count);
      const std::vector<CharacterLine> lines = lines_of(curves);
      std::vector<std::function<void()>> works = {[&] { fill(lines); },
                                                  [&] { make(lines, 0.1, no_joins); }};
      if (!version.empty()) works.push_back([&] { Filling(curves, {}, {"", 1e-4, 15, 9}); });
      const std::vector<double> time = side_by_side(5, works);
      const Made made = make(lines, 0.1, no_joins);
      const bool right =
          made.regions == 1 && made.failed == 0 && fill(lines, true).max_line_residual < 1e-10;
      ours.push_back(right ? time[0] : std::numeric_limits<double>::infinity());
      if (time.size() > 2) ratio = time[2] / ours.back();
      table.add({std::to_string(count) + " lines, " + std::to_string(made.triangles) + " triangles",
                 text("%.1f", 1e3 * ours.back()),
                 time.size() > 2 ? text("%.1f", 1e3 * time[2]) : "",
                 ratio ? text("%.1f", *ratio) : "", text("%.1f", 1e3 * time[1])});
    }
    table.print();
    promises.at_least("OpenCASCADE's time over ours, one region of 28 lines", ratio, 5);
    promises.at_most("growth of ours from 16 to 28 lines, over that of the lines",
                     ours.back() / ours[1] / (28.0 / 16), 1.3);
  }

  {
    // About 100 triangles in each of 200 cells, and as many over the whole.
    const std::vector<CharacterLine> cells = wavy_grid(20, 10), whole = wavy_grid(1, 1);
    std::vector<double> many, one;
    Made a, b;
    for (int round = 0; round < 3; ++round) {
      a = make(cells, 0.0105, no_joins);
      b = make(whole, 0.0108, no_joins);
      many.push_back(a.total());
      one.push_back(b.total());
    }
    const Made smooth = make(cells, 0.0105, all_smooth);
    Table table;
    table.add({"20,000 triangles", "regions", "triangles", "seconds", "largest angle"});
    const auto row = [&](const std::string& name, const Made& m, double time) {
      table.add({name, std::to_string(m.regions), std::to_string(m.triangles), text("%.3f", time),
                 text("%.2g deg", m.model.max_join_deg)});
    };
    row("200 regions, creases", a, median(many));
    row("200 regions, smooth", smooth, smooth.total());
    row("one region", b, median(one));
    table.print();
    const bool right = a.regions == 200 && a.failed == 0 && b.regions == 1 && b.failed == 0;
    promises.at_most("200 creased regions over one, 20,000 triangles in all",
                     right ? std::optional(median(many) / median(one)) : std::nullopt, 3);
  }
  promises.print("network");
}
