// SPDX-License-Identifier: MPL-2.0
// batten deform on whole assemblies: joints, spiders, bushes, RBE3, solids; and public decks.
#include <cmath>
#include <map>

#include "batten/io/meshes/mesh_file.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/nastran_check.h"

using namespace batten_test;
using batten::MeshFile;
using batten::Points;
using batten::Vec3;

namespace {

/// A plate of 12 × 8 quads with a stiffener along its middle, bricks under one of its corners, a
/// second plate below that is connected by two bushes, a spider, an RBE3 and a point mass.
std::string assembly() {
  std::string deck = "BEGIN BULK\n";
  const auto grid = [&](int id, double x, double y, double z) {
    deck += "GRID*," + std::to_string(id) + ",," + std::to_string(x) + "," + std::to_string(y) +
            "\n*," + std::to_string(z) + "\n";
  };
  int element = 0;
  const auto card = [&](const std::string& name, int property, const std::vector<int>& nodes) {
    deck += name + "," + std::to_string(++element) + "," + std::to_string(property);
    for (const int n : nodes) deck += "," + std::to_string(n);
    deck += "\n";
  };
  const auto at = [](int i, int j) { return 1 + 13 * j + i; };
  for (int j = 0; j <= 8; ++j)
    for (int i = 0; i <= 12; ++i) grid(at(i, j), i, j, 0);
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 12; ++i)
      card("CQUAD4", 1, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  const auto web = [&](int i, int k) { return k == 0 ? at(i, 4) : 1000 + 13 * k + i; };
  for (int k = 1; k <= 3; ++k)
    for (int i = 0; i <= 12; ++i) grid(web(i, k), i, 4, k);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 12; ++i)
      card("CQUAD4", 2, {web(i, k), web(i + 1, k), web(i + 1, k + 1), web(i, k + 1)});
  const auto below = [](int i, int j) { return 2000 + 5 * j + i; };
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 4; ++i) grid(below(i, j), 4 + i, 1 + 0.5 * j, -2);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      card("CQUAD4", 3, {below(i, j), below(i + 1, j), below(i + 1, j + 1), below(i, j + 1)});
  card("CBUSH", 9, {at(5, 1), below(1, 0)});
  card("CBUSH", 9, {at(7, 3), below(3, 4)});
  const auto brick = [](int i, int j) { return 3000 + 3 * j + i; };
  for (int j = 0; j <= 2; ++j)
    for (int i = 0; i <= 2; ++i) grid(brick(i, j), 9 + i, 5 + j, -1);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i)
      card("CHEXA", 4,
           {brick(i, j), brick(i + 1, j), brick(i + 1, j + 1), brick(i, j + 1), at(9 + i, 5 + j),
            at(10 + i, 5 + j)});
  // The last two corners are on continuation cards.
  std::string all;
  size_t from = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const std::string last = "," + std::to_string(at(10 + i, 5 + j)) + "\n";
      const size_t end = deck.find("CHEXA", from);
      const size_t line = deck.find('\n', end) + 1;
      REQUIRE(deck.substr(line - last.size(), last.size()) == last);
      const std::string more =
          "," + std::to_string(at(10 + i, 6 + j)) + "," + std::to_string(at(9 + i, 6 + j)) + "\n";
      deck.insert(line, more);
      from = line + more.size();
    }
  grid(4000, 3, 2, 5);
  deck += "RBE2,5000,4000,123456," + std::to_string(at(2, 2)) + "," + std::to_string(at(4, 2)) +
          "," + std::to_string(at(3, 1)) + "," + std::to_string(at(3, 3)) + "\n";
  deck += "CONM2,5001,4000,,1.5\n";
  grid(4001, 6, 6, 4);
  deck += "RBE3,5002,,4001,123,1.0,123," + std::to_string(at(5, 6)) + "," +
          std::to_string(at(7, 6)) + "\n";
  return deck + "ENDDATA\n";
}

const std::string kAssemblyScene = R"(unit = "mm"
mesh = "a.bdf"
[[select]]
name = "left"
box = [[-0.1, -1, -0.1], [0.1, 9, 9]]
[[select]]
name = "right"
box = [[11.9, -1, -0.1], [12.1, 9, 9]]
)";
const std::string kLift = R"([[edit]]
fixed = "left"
[[edit.handle]]
name = "right"
translate = [0, 0, 1]
)";

struct AssemblyRun {
  AssemblyRun(const CliCase& c, const std::string& scene) {
    c.file("a.bdf", assembly());
    c.file("s.toml", scene);
    result = c.run({"deform", "s.toml", "--out", "out"});
    if (!fs::exists(c / "out/report.json")) return;
    json = report(c, "out");
    const MeshFile from = MeshFile::read(c / "a.bdf"),
                   to = MeshFile::read(c / "out/a-deformed.bdf");
    for (int v = 0; v < from.shells().node_count(); ++v) {
      before[from.node_label(v)] = from.shells().points.row(v);
      after[from.node_label(v)] = to.shells().points.row(v);
    }
  }
  double length(long a, long b) const { return (after.at(a) - after.at(b)).norm(); }
  bool moved(long a) const { return after.at(a) != before.at(a); }
  CliResult result;
  nlohmann::json json;
  std::map<long, Vec3> before, after;
};

}  // namespace

TEST_CASE("everything follows the plate to which it is connected", "[apps][assemblies]") {
  const CliCase c("assembly");
  const AssemblyRun ran(c, kAssemblyScene + kLift);
  INFO(ran.result.err);
  REQUIRE(ran.result.code == 0);
  const auto& attached = ran.json["attached"];
  CHECK(attached["connections"] == 3);  // two bushes, a spider
  CHECK(attached["elements"]["CHEXA"] == 4);
  CHECK(attached["max_rigid_error"].get<double>() < 1e-13);
  CHECK(attached["moved_with_shells"] == 10);  // nine of bricks, one of the RBE3
  CHECK(attached["inverted_solids"].empty());
  // The spider's centre keeps its distances, the bushes keep their lengths, the plate below
  // follows.
  for (const long foot : {29, 31, 17, 43})
    CHECK(ran.length(4000, foot) == Approx(std::sqrt(26)).epsilon(1e-9));
  CHECK(ran.length(19, 2001) ==
        Approx((ran.before.at(19) - ran.before.at(2001)).norm()).epsilon(1e-9));
  CHECK(ran.moved(2012));
  // The RBE3's node is above the midpoint of its two nodes.
  const Vec3 middle = (ran.after.at(84) + ran.after.at(86)) / 2;
  CHECK((ran.after.at(4001) - middle).norm() == Approx(4).epsilon(1e-9));
  // Bricks keep their height.
  for (const long b : {3000, 3004, 3008}) {
    const long top = b == 3000 ? 75 : b == 3004 ? 89 : 103;
    CHECK(ran.length(b, top) == Approx(1).epsilon(0.05));
  }
}

TEST_CASE("fixed parts stay, and destroyed solids are reported", "[apps][assemblies]") {
  const CliCase c("assembly_stay");
  const AssemblyRun ran(
      c, kAssemblyScene + "[attached]\nsolids = \"stay\"\nbushes = \"stay\"\nrigid = \"stay\"\n" +
             kLift +
             "[[edit.handle]]\nname = \"push\"\ntranslate = [0, 0, -1.5]\n[[select]]\nname = "
             "\"push\"\nbox = [[9.9, 5.9, -0.1], [10.1, 6.1, 0.1]]\n");
  CHECK(ran.result.code == 4);
  CHECK(ran.result.err.find("solids, the first is") != std::string::npos);
  for (const long still : {3000, 3004, 3008, 2000, 2024, 4000}) CHECK(!ran.moved(still));
  CHECK(ran.json["attached"]["connections"] == 0);
  const CliResult bad = [&] {
    c.file("b.toml", kAssemblyScene + "[attached]\nrigid = \"smooth\"\n" + kLift);
    return c.run({"deform", "b.toml", "--out", "out"});
  }();
  CHECK(bad.code == 1);
  CHECK(bad.err.find("b.toml:10") != std::string::npos);
}

TEST_CASE("an edit that moves nothing changes no byte of an assembly", "[apps][assemblies]") {
  const CliCase c("assembly_null");
  std::string still = kAssemblyScene + kLift;
  still.replace(still.find("[0, 0, 1]"), 9, "[0, 0, 0]");
  const AssemblyRun ran(c, still);
  REQUIRE(ran.result.code == 0);
  CHECK(contents(c / "out/a-deformed.bdf") == assembly());
}

TEST_CASE("relations between features", "[apps][assemblies]") {
  const CliCase c("relations");
  c.file("plate.obj", contents(BATTEN_SOURCE_DIR "/examples/10-plate-with-holes/plate.obj"));
  const std::string head =
      "unit = \"mm\"\nmesh = \"plate.obj\"\n"
      "[[select]]\nname = \"left\"\nbox = [[0, 0, -1], [0, 300, 1]]\ngrow = 1\n"
      "[[select]]\nname = \"right\"\nbox = [[300, 0, -1], [300, 300, 1]]\ngrow = 1\n"
      "[[features]]\nof = \"hole-*\"\n";
  const std::string edit =
      "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\ntranslate = [20, 15, 60]\n"
      "rotate = { axis = [0, -1, 0.3], angle = 25 }\n";
  const auto run = [&](const std::string& relation, const std::string& more = "") {
    c.file("r.toml", head + relation + edit + more);
    return c.run({"deform", "r.toml", "--out", "out"});
  };
  std::map<std::string, Vec3> centre, axis;
  const auto look = [&] {
    const auto json = report(c, "out");
    for (const auto& h : json["holes"]) {
      const auto vec = [&](const char* key) {
        const auto v = h["after"][key].get<std::vector<double>>();
        return Vec3(v[0], v[1], v[2]);
      };
      centre[h["feature"].get<std::string>()] = vec("centre");
      axis[h["feature"].get<std::string>()] = vec("axis");
    }
  };
  const auto relation = [](const std::string& kind, const std::string& of) {
    return "[[relation]]\nname = \"r\"\ntype = \"" + kind + "\"\nof = [" + of + "]\n";
  };
  REQUIRE(run("").code == 0);
  look();
  CHECK(axis["hole-1"].cross(axis["hole-2"]).norm() > 0.01);
  const Vec3 free = centre["hole-3"];
  REQUIRE(run(relation("parallel", "\"hole-1\", \"hole-2\"")).code == 0);
  look();
  CHECK(axis["hole-1"].cross(axis["hole-2"]).norm() < 1e-9);
  REQUIRE(run(relation("distance", "\"hole-1\", \"hole-2\"")).code == 0);
  look();
  CHECK((centre["hole-1"] - centre["hole-2"]).norm() == Approx(210).epsilon(1e-9));
  REQUIRE(run(relation("spacing", "\"hole-1\", \"hole-3\", \"hole-5\"")).code == 0);
  look();
  CHECK((centre["hole-1"] - 2 * centre["hole-3"] + centre["hole-5"]).norm() < 1e-8);
  REQUIRE(run(relation("symmetric", "\"hole-1\", \"hole-4\"") +
              "plane = { normal = [0, 1, 0], origin = [0, 150, 0] }\n")
              .code == 0);
  look();
  CHECK((centre["hole-1"] + centre["hole-4"]).y() == Approx(300).epsilon(1e-9));
  CHECK(std::abs((centre["hole-1"] - centre["hole-4"]).x()) < 1e-8);
  // Scaling one hole does not change the others.
  REQUIRE(run("", "[[edit.scale]]\nfeature = \"hole-3\"\nfactor = 1.3\n").code == 0);
  look();
  CHECK((centre["hole-3"] - free).norm() < 1e-8);

  CHECK(run(relation("coaxial", "\"hole-1\", \"hole-2\"")).err.find("from the axis of") !=
        std::string::npos);
  CHECK(run(relation("spacing", "\"hole-1\", \"hole-2\"")).err.find("3 or more") !=
        std::string::npos);
  CHECK(run(relation("spacing", "\"hole-1\", \"hole-5\", \"hole-3\"")).err.find("equal spacings") !=
        std::string::npos);
  CHECK(run(relation("parallel", "\"hole-1\", \"hole-9\"")).err.find("hole-9") !=
        std::string::npos);
  CHECK(run(relation("symmetric", "\"hole-1\", \"hole-4\"")).err.find("plane") !=
        std::string::npos);
}

TEST_CASE("features tilt with the sheet that is lifted without rotation", "[apps][assemblies]") {
  const CliCase c("tilt");
  c.file("plate.obj", contents(BATTEN_SOURCE_DIR "/examples/10-plate-with-holes/plate.obj"));
  const std::string scene =
      "unit = \"mm\"\nmesh = \"plate.obj\"\n"
      "[[select]]\nname = \"left\"\nbox = [[0, 0, -1], [0, 300, 1]]\ngrow = 1\n"
      "[[select]]\nname = \"right\"\nbox = [[300, 0, -1], [300, 300, 1]]\ngrow = 1\n"
      "[[features]]\nof = \"hole-*\"\n"
      "[[edit]]\nfixed = \"left\"\n";
  const std::string lift = "[[edit.handle]]\nname = \"right\"\ntranslate = [0, 0, 120]\n";
  const auto turned = [&](const std::string& keys, const std::string& more = "") {
    c.file("s.toml", scene + keys + lift + more);
    const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    std::map<std::string, double> degrees;
    const auto json = report(c, "out");
    CHECK(json["failed_checks"].empty());
    for (const auto& f : json["features"])
      degrees[f["name"].get<std::string>()] = f["rotation_deg"].get<double>();
    return degrees;
  };
  for (const auto& [name, degrees] : turned("rotation_mode = \"harmonic\"\n"))
    CHECK(degrees < 1e-6);
  // Slope in the middle of a cubic S-shape of 120 over 280: 3/2 of 120/280, slightly less due to
  // the hole.
  for (const std::string way : {"estimated", "dual", "nonlinear"}) {
    INFO(way);
    const auto degrees = turned("rotation_mode = \"" + way + "\"\n");
    CHECK(degrees.at("hole-3") > 20);
    CHECK(degrees.at("hole-3") < 36);
    CHECK(degrees.at("hole-1") == Approx(degrees.at("hole-2")).epsilon(0.02));
  }
  const auto angles =
      turned("", "[[edit.rotate_feature]]\nfeature = \"hole-3\"\naxis = [0, 0, 1]\nangle = 12\n");
  CHECK(angles.at("hole-3") == Approx(12));
  CHECK(angles.at("hole-1") > 5);
  c.file("s.toml",
         scene + lift +
             "[[edit.rotate_feature]]\nfeature = \"hole-9\"\naxis = [0, 0, 1]\nangle = 12\n");
  const CliResult bad = c.run({"deform", "s.toml", "--out", "out"});
  CHECK(bad.code == 1);
  CHECK(bad.err.find("'hole-9'") != std::string::npos);
}

TEST_CASE("public decks are edited whole, and come back to the byte where nothing moves",
          "[apps][assemblies][data]") {
  const auto folder = optional_data("decks-public");
  if (folder.empty()) {
    WARN("skipped: no decks-public beside the project (BATTEN_TEST_DATA)");
    return;
  }
  const auto select = [](const std::string& name, const std::string& condition) {
    return "[[select]]\nname = \"" + name + "\"\n" + condition + "\n";
  };
  const auto beyond = [&](const std::string& name, const std::string& through,
                          const std::string& normal, const std::string& more = "") {
    return select(name, more + "plane = { origin = " + through + ", normal = " + normal + " }");
  };
  const std::string all_holes = "[[features]]\nof = \"hole-*\"\n";
  struct Deck {
    std::string file, scene, translate;
  };
  const std::vector<Deck> decks = {
      {"W1000BOstat.dat",
       select("plate", "property = \"1\"") +
           beyond("left", "[2895, 0, 0]", "[-1, 0, 0]", "any = \"plate\"\n") +
           beyond("right", "[3495, 0, 0]", "[1, 0, 0]", "any = \"plate\"\n") + all_holes,
       "[15, 0, 0]"},
      {"wingbox_stitched_together-000.bdf",
       beyond("root", "[0, 0.1, 0]", "[0, -1, 0]") +
           select("nose", "box = [[99, 95.9, -99], [101, 97, 99]]") +
           select("right", "box = [[159, 95.9, -99], [161, 97, 99]]") +
           select("left", "any = [\"root\", \"nose\"]"),
       "[3, 0, 0]"},
      {"Box.bdf",
       beyond("left", "[0, 0.1, 0]", "[0, -1, 0]") + beyond("right", "[0, 39.9, 0]", "[0, 1, 0]") +
           select("rib", "property = \"2\"") + "[[feature]]\nname = \"rib\"\n",
       "[0, 2, 0]"},
      {"fuselage.bdf",
       beyond("left", "[0, 0, 3.66]", "[0, 0, -1]") + beyond("right", "[0, 0, 5.48]", "[0, 0, 1]") +
           select("frame", "box = [[-9, -9, 4.26], [9, 9, 4.28]]") +
           "[[feature]]\nname = \"frame\"\n",
       "[0, 0, 0.09144]"},
      {"rbe3.bdf",
       beyond("left", "[0, 0, 0.1]", "[0, 0, -1]") +
           select("right", "box = [[-0.2, 0.4, 2.3], [0.2, 0.6, 2.7]]"),
       "[0.1, 0.2, 0]"},
      {"Slender_Beam.bdf",
       beyond("left", "[0.1, 0, 0]", "[-1, 0, 0]") + beyond("right", "[0.99, 0, 0]", "[1, 0, 0]"),
       "[0, 0.01, 0.2]"},
      {"battery_pack.bdf",
       beyond("left", "[0.001, 0, 0]", "[-1, 0, 0]") +
           beyond("right", "[0.061, 0, 0]", "[1, 0, 0]") + all_holes,
       "[0.001866, 0, 0]"},
      {"nx_ogstr.bdf",
       select("left", "any = [\"one\", \"other\"]") + beyond("one", "[0.1, 0, 0]", "[-1, 0, 0]") +
           beyond("other", "[99, 0, 0]", "[1, 0, 0]") +
           select("right", "box = [[39, 60, -1], [61, 90, 1]]"),
       "[0, 0, 5]"},
      {"bend_A1_105.bdf",
       beyond("left", "[20, 0, 0]", "[-1, 0, 0]") + beyond("right", "[790, 0, 0]", "[1, 0, 0]"),
       "[40, 0, 0]"}};
  const CliCase c("public_decks");
  for (const Deck& deck : decks)
    for (const bool moves : {true, false}) {
      INFO(deck.file << (moves ? "" : ", moving nothing"));
      const fs::path from = folder / deck.file;
      c.file("s.toml",
             "unit = \"mm\"\nmesh = \"" + from.string() + "\"\n" + deck.scene +
                 "[[edit]]\nfixed = \"left\"\n[[edit.handle]]\nname = \"right\"\ntranslate = " +
                 (moves ? deck.translate : "[0, 0, 0]") + "\n[output]\nlarge_field = true\n");
      fs::remove_all(c / "out");
      const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
      INFO(r.err);
      REQUIRE(r.code == 0);
      const auto json = report(c, "out");
      CHECK(json["failed_checks"].empty());
      const fs::path to =
          c / ("out/" + from.stem().string() + "-deformed" + from.extension().string());
      if (!moves) {
        CHECK(contents(to) == contents(from));
        continue;
      }
      CHECK(json["displacement"]["largest"].get<double>() > 0);
      check_deck_changes(from, to, 1e-9);
      const MeshFile a = MeshFile::read(from), b = MeshFile::read(to);
      for (size_t e = 0; e < a.other_elements().size(); ++e)
        if (const auto& other = a.other_elements()[e];
            other.kind == batten::NonShellElement::Kind::Rigid) {
          const auto fit =
              batten::fit_similarity(a.shells().points, b.shells().points, other.nodes, 1);
          CHECK(fit.max_error < 1e-9);  // limited by the large field format
        }
      CHECK(batten::inverted_solids(a.other_elements(), a.shells().points, b.shells().points)
                .empty());
    }
}
