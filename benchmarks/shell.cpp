// SPDX-License-Identifier: MPL-2.0
// Stress analysis compared with CalculiX: whole processes, each with the coarsest mesh within 0.5 %
// of its own limit.
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "bench.h"

namespace {

using namespace batten;
using namespace batten::bench;
namespace fs = std::filesystem;

constexpr double kNear = 5e-3;

struct Run {
  int size = 0;  // elements per side, or the index of the edge length
  long unknowns = 0;
  double seconds = 0, result = 0;
};

// ---- the cases as scenes and as grids
// ------------------------------------------------------------

constexpr double kSlope = 40 * 3.14159265358979323846 / 180;

// Patches of (i, j) in 0 … 1; the side j = 1 of each is the side j = 0 of the next.
struct Case {
  std::string name, scene;  // scene: with EDGE as placeholder of the edge length
  std::vector<double> edges;
  std::vector<Vec3 (*)(double, double)> patches;
  std::string deck;  // material and section
  int loaded;        // index of the patch
  std::string gravity;
  std::array<double, 2> measured;  // (i, j) on the last patch
  int component;
};

Vec3 roof(double i, double j) {
  return {25 * std::sin(kSlope * i), 25 * std::cos(kSlope * i), 25 * j};
}
Vec3 wall(double i, double j) { return {0, 0.5 * i, 0.6 * j}; }
Vec3 shelf(double i, double j) { return {0.8 * j, 0.5 * i, 0.6}; }

Case scordelis() {
  Case c{"Scordelis-Lo roof", "", {6, 3, 2, 1.5, 1, 0.7}, {&roof}, "", 0, "", {1, 0}, 1};
  c.scene = R"(name = "roof"
unit = "m"
[[curve]]
name = "crown"
points = [[0, 25, 0], [0, 25, 25]]
[[curve]]
name = "wall"
arc = { centre = [0, 0, 25], radius = 25, angles = [90, 50] }
[[curve]]
name = "free"
points = [[16.0696902421635, 19.1511110779744, 0], [16.0696902421635, 19.1511110779744, 25]]
[[curve]]
name = "middle"
arc = { centre = [0, 0, 0], radius = 25, angles = [90, 50] }

[mesh]
edge_length = EDGE
[stress]
thickness = 0.25
young = 4.32e8
poisson = 0
supports = [
  { curve = "crown", type = "symmetric", normal = [1, 0, 0] },
  { curve = "middle", type = "symmetric", normal = [0, 0, 1] },
  { curve = "wall", type = "prescribed", directions = [[1, 0, 0], [0, 1, 0]] },
]
loads = [{ traction = [0, -90, 0] }]
)";
  c.deck = "4.32e8,0\n*DENSITY\n360\n*SHELL SECTION,ELSET=ALL,MATERIAL=M\n0.25\n";
  c.gravity = "1.,0.,-1.,0.";
  return c;
}

Case folded() {
  Case c{"folded plate", "", {0.5, 0.25, 0.12, 0.08, 0.05, 0.03}, {&wall, &shelf}, "", 1, "",
         {0.5, 1},       2};
  const auto line = [](const std::string& name, const std::string& points) {
    return "[[curve]]\nname = \"" + name + "\"\npoints = " + points + "\n";
  };
  c.scene =
      "name = \"plate\"\nunit = \"m\"\n" + line("foot", "[[0, 0, 0], [0, 0.5, 0]]") +
      line("left", "[[0, 0, 0], [0, 0, 0.6]]") + line("right", "[[0, 0.5, 0], [0, 0.5, 0.6]]") +
      line("knee", "[[0, 0, 0.6], [0, 0.5, 0.6]]") + line("a", "[[0, 0, 0.6], [0.8, 0, 0.6]]") +
      line("b", "[[0, 0.5, 0.6], [0.8, 0.5, 0.6]]") +
      line("tip", "[[0.8, 0, 0.6], [0.8, 0.5, 0.6]]") +
      "\n[[face]]\nname = \"shelf\"\nloops = [[\"knee\", \"a\", \"tip\", \"b\"]]\n"
      "[mesh]\nedge_length = EDGE\n[stress]\nthickness = 0.02\nyoung = 1e9\npoisson = 0.3\n"
      "supports = [{ curve = \"foot\" }]\n"
      "loads = [{ traction = [0, 0, -100], face = \"shelf\" }]\n";
  c.deck = "1e9,0.3\n*DENSITY\n5000\n*SHELL SECTION,ELSET=ALL,MATERIAL=M\n0.02\n";
  c.gravity = "1.,0.,0.,-1.";
  return c;
}

// ---- CalculiX -----------------------------------------------------------------------------------

// A deck of n × n quads per patch, or twice as many triangles.
class Deck {
 public:
  Deck(const Case& c, const std::string& kind, int n) : case_(c), kind_(kind), n_(n) {
    steps_ = kind == "S3" ? n : 2 * n;
    for (size_t p = 0; p < c.patches.size(); ++p) add_patch(static_cast<int>(p));
  }
  long nodes() const { return count_; }

  void write(const fs::path& file) {
    std::ofstream out(file);
    out << "*NODE\n" << nodes_.str();
    for (size_t p = 0; p < case_.patches.size(); ++p)
      out << "*ELEMENT,TYPE=" << kind_ << ",ELSET=PATCH" << p << "\n"
          << elements_[static_cast<int>(p)].str();
    out << "*ELSET,ELSET=ALL\n";
    for (size_t p = 0; p < case_.patches.size(); ++p) out << "PATCH" << p << "\n";
    out << "*MATERIAL,NAME=M\n*ELASTIC\n"
        << case_.deck << supports() << "*NSET,NSET=P\n"
        << id(static_cast<int>(case_.patches.size()) - 1,
              static_cast<int>(std::lround(case_.measured[0] * steps_)),
              static_cast<int>(std::lround(case_.measured[1] * steps_)))
        << "\n*STEP\n*STATIC\n*DLOAD\nPATCH" << case_.loaded << ",GRAV," << case_.gravity
        << "\n*NODE PRINT,NSET=P,GLOBAL=YES\nU\n*END STEP\n";
  }

 private:
  // The first row of a patch is the last one of its predecessor.
  int id(int patch, int i, int j) const {
    return patch > 0 && j == 0 ? ids_.at({patch - 1, i, steps_}) : ids_.at({patch, i, j});
  }
  void add_patch(int p) {
    for (int i = 0; i <= steps_; ++i)
      for (int j = p > 0 ? 1 : 0; j <= steps_; ++j) {
        if (kind_ == "S8R" && i % 2 && j % 2) continue;
        ids_[{p, i, j}] = ++count_;
        const Vec3 x = case_.patches[p](double(i) / steps_, double(j) / steps_);
        nodes_ << count_ << text(",%.12g,%.12g,%.12g\n", x[0], x[1], x[2]);
      }
    using Corners = std::vector<std::array<int, 2>>;
    const auto add = [&](const Corners& at) {
      elements_[p] << ++element_;
      for (const auto& [i, j] : at) elements_[p] << "," << id(p, i, j);
      elements_[p] << "\n";
    };
    for (int a = 0; a < n_; ++a)
      for (int b = 0; b < n_; ++b) {
        const int i = a * steps_ / n_, j = b * steps_ / n_;
        if (kind_ == "S8R") {
          add({{i, j},
               {i + 2, j},
               {i + 2, j + 2},
               {i, j + 2},
               {i + 1, j},
               {i + 2, j + 1},
               {i + 1, j + 2},
               {i, j + 1}});
        } else if (kind_ == "S6") {
          add({{i, j}, {i + 2, j}, {i + 2, j + 2}, {i + 1, j}, {i + 2, j + 1}, {i + 1, j + 1}});
          add({{i, j}, {i + 2, j + 2}, {i, j + 2}, {i + 1, j + 1}, {i + 1, j + 2}, {i, j + 1}});
        } else {
          add({{i, j}, {i + 1, j}, {i + 1, j + 1}});
          add({{i, j}, {i + 1, j + 1}, {i, j + 1}});
        }
      }
  }
  // Fixes rotations about in-plane axes only: CalculiX becomes too stiff if drilling rotations are
  // fixed.
  std::string supports() const {
    std::ostringstream rows, middle;
    for (const auto& [at, node] : ids_) {
      const auto& [p, i, j] = at;
      if (case_.patches.size() > 1) {
        if (p == 0 && j == 0) rows << node << ",1,6\n";
        continue;
      }
      if (i == 0) rows << node << ",1,1\n" << (j > 0 ? text("%d,6,6\n", node) : "");
      if (j == 0) rows << node << ",3,3\n" << (i > 0 ? text("%d,5,5\n", node) : "");
      if (j == 0 && i > 0) middle << node << "\n";
      if (j == steps_) rows << node << ",1,2\n";
    }
    const std::string turned =
        middle.str().empty()
            ? ""
            : "*NSET,NSET=MID\n" + middle.str() + "*TRANSFORM,NSET=MID,TYPE=C\n0,0,0,0,0,1\n";
    return turned + "*BOUNDARY\n" + rows.str();
  }

  const Case& case_;
  std::string kind_;
  int n_, steps_, count_ = 0, element_ = 0;
  std::map<std::array<int, 3>, int> ids_;
  std::ostringstream nodes_;
  std::map<int, std::ostringstream> elements_;
};

bool quietly(const std::string& command) {
  return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

Run ccx(const Case& c, const std::string& kind, int n, const fs::path& folder) {
  Deck deck(c, kind, n);
  deck.write(folder / "deck.inp");
  Run run{n, 6 * deck.nodes(), 0, 0};
  run.seconds = wall_seconds_of([&] { quietly("cd '" + folder.string() + "' && ccx -i deck"); });
  std::ifstream results(folder / "deck.dat");
  for (std::string line, last; std::getline(results, line);)
    if (!line.empty()) {
      std::istringstream numbers(line);
      int node = 0;
      Vec3 u;
      if (numbers >> node >> u[0] >> u[1] >> u[2]) run.result = u[c.component];
    }
  return run;
}

Run batten_run(const Case& c, double edge, const fs::path& folder) {
  std::string scene = c.scene;
  scene.replace(scene.find("EDGE"), 4, format_number(edge));
  std::ofstream(folder / "s.toml") << scene;
  Run run;
  run.seconds = wall_seconds_of([&] {
    quietly("cd '" + folder.string() +
            "' && BATTEN_XVFB= DISPLAY= '" BATTEN_PROGRAM "' stress s.toml --accuracy 0 --quiet --threads 1 --out out");
  });
  std::ifstream file(folder / "out/report.json");
  if (!file) return run;
  const auto report = nlohmann::json::parse(file);
  run.unknowns = report["stress"]["unknowns"];
  run.result = report["stress"]["cases"][0]["displacement"][c.component];
  run.size = report["surface"]["triangles"];
  return run;
}

// The first of the runs, coarse to fine, within kNear of the last one; repeated three times for the
// time.
template <class Again>
Run coarsest(const std::vector<Run>& runs, const Again& again) {
  const double limit = runs.back().result;
  size_t first = runs.size() - 1;
  while (first > 0 && std::abs(runs[first - 1].result / limit - 1) < kNear) --first;
  Run chosen = runs[first];
  std::vector<double> seconds;
  for (int round = 0; round < 5; ++round) seconds.push_back(again(first).seconds);
  chosen.seconds = median(seconds);
  return chosen;
}

void compare(const Case& c, const fs::path& folder, Table& table, Checks& checks) {
  std::vector<Run> own;
  for (const double edge : c.edges) own.push_back(batten_run(c, edge, folder));
  const Run batten = coarsest(own, [&](size_t k) { return batten_run(c, c.edges[k], folder); });
  const auto add = [&](const std::string& who, const Run& run, double limit) {
    table.add({c.name, who, std::to_string(run.size), std::to_string(run.unknowns),
               text("%.3f", run.seconds), text("%.5g", run.result), text("%.5g", limit),
               text("%.2f", run.seconds / batten.seconds)});
  };
  add("Batten (triangles)", batten, own.back().result);
  std::map<std::string, double> ratio;
  for (const std::string kind : {"S3", "S6", "S8R"}) {
    const std::vector<int> sizes = kind == "S3" ? std::vector<int>{4, 8, 16, 32, 64, 128, 192}
                                                : std::vector<int>{2, 4, 8, 16, 32, 64};
    std::vector<Run> runs;
    for (const int n : sizes) runs.push_back(ccx(c, kind, n, folder));
    if (runs.back().result == 0) continue;  // no ccx
    const Run peer = coarsest(runs, [&](size_t k) { return ccx(c, kind, sizes[k], folder); });
    add("CalculiX " + kind + " (per side)", peer, runs.back().result);
    ratio[kind] = peer.seconds / batten.seconds;
  }
  const auto of = [&](const std::string& kind) {
    return ratio.count(kind) ? std::optional(ratio[kind]) : std::nullopt;
  };
  checks.at_least(c.name + ": seconds of S6 over Batten's", of("S6"), 10);
  checks.at_least(c.name + ": seconds of S8R over Batten's", of("S8R"), 1);
}

}  // namespace

int main() {
  const fs::path folder = fs::temp_directory_path() / ("batten_shell_" + std::to_string(getpid()));
  fs::create_directories(folder);
  Table table;
  table.add(
      {"case", "element", "size", "unknowns", "seconds", "result", "own limit", "over Batten's"});
  Checks checks;
  for (const Case& c : {scordelis(), folded()}) compare(c, folder, table, checks);
  fs::remove_all(folder);
  table.print();
  checks.print("shell");
}
