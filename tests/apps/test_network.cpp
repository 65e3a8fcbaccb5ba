// SPDX-License-Identifier: MPL-2.0
// Curve networks: batten run and batten skin, from curves to a report.
#include <array>
#include <cmath>
#include <map>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

struct Point {
  int x, y, z;
};
std::string text(const Point& p) {
  return "[" + std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z) + "]";
}

/// The edges of a box of 40 × 30 × 20 as [[curve]]s: e1 … e12.
std::string box() {
  std::string scene;
  int count = 0;
  for (int a = 0; a < 8; ++a)
    for (const int bit : {1, 2, 4}) {
      if (a & bit) continue;
      const auto point = [](int i) {
        return Point{i & 1 ? 40 : 0, i & 2 ? 30 : 0, i & 4 ? 20 : 0};
      };
      Point p = point(a), q = point(a | bit);
      if (a % 3 == 0) std::swap(p, q);
      scene += "[[curve]]\nname = \"e" + std::to_string(++count) + "\"\npoints = [" + text(p) +
               ", " + text(q) + "]\n";
    }
  return scene;
}

const std::string kNetworkHead = "unit = \"mm\"\n\n";
const std::string kCoarse = "[mesh]\nedge_length = 8\n";

}  // namespace

TEST_CASE("run makes all surfaces of a network, as one solid", "[apps][network]") {
  const CliCase c("network");
  c.file("s.toml", kNetworkHead + box() + kCoarse +
                       "[output]\nstep = \"box.step\"\nvtp = \"box.vtp\"\nvtu = \"box.vtu\"\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  CHECK(r.out.find("6 found, 6 skinned") != std::string::npos);
  CHECK(r.out.find("closed") != std::string::npos);
  CHECK(r.out.find("1 solid, valid") != std::string::npos);
  const auto j = report(c, "out");
  CHECK(j["network"]["curves"] == 12);
  CHECK(j["network"]["edges"] == 12);
  CHECK(j["network"]["nodes"] == 8);
  CHECK(j["faces"].size() == 6);
  double area = 0;
  for (const auto& region : j["faces"]) {
    CHECK(region["skinned"] == true);
    CHECK(region["loops"][0].size() == 4);
    CHECK(region["hole_filling_area"].get<double>() == Approx(region["area"].get<double>()));
    CHECK(region["min_jacobian_ratio"].get<double>() > 0.9);
    area += region["area"].get<double>();
  }
  CHECK(area == Approx(5200.0));
  CHECK(j["surface"]["area"].get<double>() == Approx(area));
  CHECK(j["surface"]["faces"] == 6);
  CHECK(j["surface"]["bending_energy"].get<double>() == Approx(0.0).margin(1e-6));
  REQUIRE(j["shells"].size() == 1);
  CHECK(j["shells"][0]["closed"] == true);
  CHECK(j["shells"][0]["volume"].get<double>() == Approx(24000.0));
  CHECK(j["joins"].size() == 12);
  for (const auto& join : j["joins"]) {
    CHECK(join["continuity"] == "G0");
    CHECK(join["max_deg"].get<double>() == Approx(90.0).margin(1e-6));
  }
  CHECK(j["step"]["solids"] == 1);
  CHECK(j["step"]["volume"].get<double>() == Approx(24000.0));
  CHECK(j["left_over"]["free_edges"].empty());
  CHECK(j["left_over"]["unused_edges"].empty());
  CHECK(j["failed_checks"].empty());
}

TEST_CASE("the user's settings of faces and joins are applied", "[apps][network]") {
  const CliCase c("network_words");
  // z = 0 is bounded by e1, e2, and the two curves from their other ends.
  c.file("s.toml", kNetworkHead + box() + kCoarse);
  const CliResult info = c.run({"info", "s.toml"});
  INFO(info.out << info.err);
  REQUIRE(info.code == 0);
  CHECK(info.out.find("12 edges between 8 nodes") != std::string::npos);
  CHECK(info.out.find("6 faces") != std::string::npos);

  c.file("open.toml", kNetworkHead + box() + kCoarse +
                          "[[face]]\nloops = [[\"e1\", \"e2\", \"e4\", \"e6\"]]\nsurface = "
                          "false\n");
  const CliResult r = c.run({"run", "open.toml", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  CHECK(j["faces"].size() == 5);
  CHECK(j["left_over"]["free_edges"].size() == 4);
  CHECK(j["shells"][0]["closed"] == false);
}

TEST_CASE("a face has its own domain and its own edges", "[apps][network]") {
  const CliCase c("network_region_skin");
  // A square of 20, and another one on one of its sides that rises by 5.
  const std::string line = "[[curve]]\nname = ";
  const std::string strip = line +
                            "\"a\"\npoints = [[0,0,0],[20,0,0],[20,20,0],[0,20,0],[0,0,0]]\n" +
                            line + "\"b\"\npoints = [[20,0,0],[40,0,5],[40,20,5],[20,20,0]]\n";
  const auto words = [](const std::string& more) {
    return "[[face]]\nname = \"fine\"\nloops = [[\"a\"]]\n" + more;
  };
  c.file("usual.toml", kNetworkHead + strip + words("") + kCoarse);
  c.file("fine.toml", kNetworkHead + strip + words("edge_length = 1\n") + kCoarse);
  c.file("plane.toml", kNetworkHead + strip + words("domain = \"projected\"\n") + kCoarse);
  c.file("ring.toml", kNetworkHead + strip + words("domain = \"annulus\"\n") + kCoarse);
  const auto of = [&](const std::string& name) {
    const CliResult r = c.run({"run", name + ".toml", "--out", name});
    INFO(r.out << r.err);
    REQUIRE(r.code == 0);
    std::map<std::string, nlohmann::json> regions;
    const auto j = report(c, name);
    for (const auto& region : j["faces"])
      regions[region["name"] == "fine" ? "fine" : "other"] = region;
    REQUIRE(regions.size() == 2);
    return regions;
  };
  auto usual = of("usual"), fine = of("fine"), plane = of("plane");
  const auto triangles = [](const nlohmann::json& region) {
    return region["triangles"].get<int>();
  };
  CHECK(triangles(fine["fine"]) > 2 * triangles(usual["fine"]));
  CHECK(triangles(fine["other"]) < 1.5 * triangles(usual["other"]));
  CHECK(usual["fine"]["domain"] == "polygon");
  CHECK(plane["fine"]["domain"] == "projected");
  CHECK(plane["other"]["domain"] == "polygon");
  CHECK(plane["fine"]["area"].get<double>() == Approx(400.0).epsilon(0.01));
  const CliResult ring = c.run({"run", "ring.toml", "--out", "ring"});
  CHECK(ring.code == 1);
  CHECK(ring.err.find("expected annulus = true and no domain") != std::string::npos);
}

TEST_CASE("features that cannot be kept are named, with exit code 4", "[apps][network]") {
  const CliCase c("network_missed");
  // Two perpendicular planes with a requested smooth edge: the corners of a box have no common
  // tangent plane, which the ends report; the requested continuity is not reached along the whole
  // edge.
  c.file("s.toml",
         kNetworkHead + box() + kCoarse + "[[join]]\ncurves = [\"e1\"]\ncontinuity = \"smooth\"\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.out << r.err);
  const auto j = report(c, "out");
  bool said = false;
  for (const auto& join : j["joins"])
    if (join["edge"] == "e1") {
      CHECK(join["requested"] == true);
      said = join["continuity"] != "smooth"
                 ? !join["reason"].get<std::string>().empty()
                 : join["open_ends"][0] == true && join["open_ends"][1] == true;
    }
  CHECK(said);
}

TEST_CASE("stiffness along a curve acts in all faces that have it", "[apps][network]") {
  // Two shells side by side; bending along the curve between them costs more. `top`: x of its
  // highest point; the others have it at 50.
  const auto areas = [](const std::string& value, const std::string& top) {
    const CliCase c("along");
    std::string scene = "unit = \"mm\"\n\n";
    for (int i = 0; i < 3; ++i) {
      const std::string y = std::to_string(100 * i);
      scene += "[[curve]]\nname = \"arch " + std::to_string(i) + "\"\narc = [[0," + y + ",0],[" +
               (i == 1 ? top : "50") + "," + y + ",20],[100," + y + ",0]]\n";
    }
    for (const char* x : {"0", "100"})
      scene += "[[curve]]\nname = \"side " + std::string(x) + "\"\npoints = [[" + x + ",0,0],[" +
               x + ",100,0],[" + x + ",200,0]]\n";
    c.file("s.toml", scene +
                         "[mesh]\nedge_length = 20\n[[stiffness]]\nname = \"w\"\ntype = "
                         "\"beta\"\nalong = \"arch 1\"\nvalue = " +
                         value + "\n");
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto report = nlohmann::json::parse(contents(c / "out/report.json"));
    REQUIRE(report["faces"].size() == 2);
    return std::array{report["faces"][0]["area"].get<double>(),
                      report["faces"][1]["area"].get<double>()};
  };
  const auto even = areas("0", "58"), along = areas("50", "58");
  for (const size_t r : {0, 1}) CHECK(std::abs(along[r] / even[r] - 1) > 1e-4);
  // Equal arches give a cylinder, whatever the stiffness field.
  for (const char* value : {"0", "50"})
    for (const double area : areas(value, "50")) CHECK(area == Approx(22070 / 2).epsilon(1e-3));
}

TEST_CASE("half a model is enough where it is symmetric", "[apps][network]") {
  const CliCase c("symmetry");
  // A house with its ridge in the plane y = 0: half of the walls, one slope of the roof.
  const std::string head = "unit = \"mm\"\n[skin]\nsymmetry = \"y\"\n[output]\nstep = \"h.step\"\n";
  const auto line = [](const std::string& name, const std::string& points) {
    return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points + "]\n";
  };
  std::string lines = line("ridge", "[0,0,50],[100,0,50]");
  for (const std::string x : {"0", "100"}) {
    lines += line("post " + x, "[" + x + ",30,0],[" + x + ",30,30]");
    lines += line("sill " + x, "[" + x + ",0,0],[" + x + ",30,0]");
    lines += line("slope " + x, "[" + x + ",30,30],[" + x + ",0,50]");
  }
  lines += line("wall", "[0,30,0],[100,30,0]") + line("eaves", "[0,30,30],[100,30,30]");
  c.file("h.toml", head + lines +
                       "[[face]]\nname = \"roof\"\nloops = [[\"ridge\", \"slope 0\", "
                       "\"eaves\", \"slope 100\"]]\n"
                       "[[join]]\ncurves = [\"eaves\"]\ncontinuity = \"G0\"\n");
  const CliResult r = c.run({"run", "h.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto report = nlohmann::json::parse(contents(c / "out/report.json"));
  // Two walls, two slopes, two gables, the floor: complete where they cross the plane.
  CHECK(report["faces"].size() == 7);
  CHECK(report["step"]["solids"] == 1);
  CHECK(report["step"]["volume"].get<double>() ==
        Approx(100 * (60 * 30 + 60 * 20 / 2)).epsilon(1e-6));
  int roofs = 0, asked = 0;
  for (const auto& region : report["faces"])
    roofs += region["name"] == "roof" || region["name"] == "mirrored roof";
  for (const auto& join : report["joins"]) asked += join["requested"].get<bool>();
  CHECK(roofs == 2);
  CHECK(asked == 2);
  const CliCase wrong("symmetry_wrong");
  wrong.fails(head + line("a", "[0,-20,0],[0,30,0]"), 1,
              {"s.toml:2:1:", "'a', which crosses the plane of symmetry", "(0, -20, 0)"});
  wrong.fails("unit = \"mm\"\n[skin]\nsymmetry = \"w\"\n" + lines, 1,
              {"s.toml:3:12:", "one of: x, y, z"});
}

TEST_CASE("errors in a network's settings are reported with their position", "[apps][network]") {
  const CliCase c("network_mistakes");
  c.fails(kNetworkHead + box() + "[[join]]\ncurves = [\"e13\"]\ncontinuity = \"smooth\"\n", 1,
          {"s.toml:40:11:", "e13", "e3", "did you mean"});
  c.fails(kNetworkHead + box() + "[[face]]\nloops = [[\"e1\", \"e2\", \"nothing\"]]\n", 1,
          {"s.toml:40:9:", "nothing"});
  c.fails(kNetworkHead + box() + "[[face]]\nloops = [[\"e1\", \"e2\"]]\n", 1, {"s.toml:40:9:"});
  c.fails(kNetworkHead +
              "[[curve]]\nname = \"a\"\npoints = [[0,0,0], [1,0,0]]\n"
              "[[curve]]\nname = \"b\"\npoints = [[1,0,0], [1,1,0]]\n",
          1, {"s.toml: found", "found no closed loop of curves"});
  const std::string pressed = "[[load]]\nname = \"p\"\ntype = \"pressure\"\nvalue = 1\n";
  c.fails(kNetworkHead + box() + pressed + "faces = [\"bottom\"]\n", 1,
          {"s.toml:43:10:", "'bottom'", "expected one of", "face 1"});
  c.fails(kNetworkHead + box() + "[[offset]]\nname = \"m\"\ncurve = \"e99\"\nvalue = 1\n", 1,
          {"s.toml:41:9:", "'e99'", "e9"});
}

TEST_CASE("sculpt works on a network as on one face: sweep, motion, record and replay",
          "[apps][network]") {
  const CliCase c("network_sculpt");
  c.file("s.toml", kNetworkHead + box() + kCoarse +
                       "[[load]]\nname = \"p\"\ntype = \"pressure\"\nvalue = 0\n"
                       "[output]\nvtp = \"box.vtp\"\n");
  const CliResult first = c.run({"sculpt", "s.toml", "--out", "out", "--sweep", "p=0:4:3", "--time",
                                 "0.1", "--dt", "0.05", "--set", "p=2", "--record", "log.jsonl"});
  INFO(first.out << first.err);
  REQUIRE((first.code == 0 || first.code == 4));  // 4: no pictures without a display
  const auto j = report(c, "out");
  REQUIRE(j["sculpting"]["sweeps"][0]["rows"].size() == 3);
  const auto& rows = j["sculpting"]["sweeps"][0]["rows"];
  CHECK(rows[2]["volume"].get<double>() > 1.0001 * rows[0]["volume"].get<double>());
  CHECK(j["sculpting"]["motion"]["rows"].size() == 3);
  CHECK(j["sculpting"]["residual"].get<double>() <= 1e-10);
  CHECK(j["surface"]["faces"] == 6);
  const CliResult again = c.run({"sculpt", "s.toml", "--out", "again", "--replay", "log.jsonl"});
  INFO(again.out << again.err);
  REQUIRE((again.code == 0 || again.code == 4));
  CHECK(report(c, "again")["sculpting"]["bending_energy"] == j["sculpting"]["bending_energy"]);
}

TEST_CASE("the free edges of an annulus are not reported as apart, other curves are",
          "[apps][network]") {
  const CliCase c("network_apart");
  const std::string line = "[[curve]]\nname = ";
  c.file("s.toml", kNetworkHead + kCoarse + line +
                       "\"low\"\ncircle = { centre = [0,0,0], radius = 10 }\n" + line +
                       "\"high\"\ncircle = { centre = [0,0,15], radius = 10 }\n" + line +
                       "\"far\"\npoints = [[40,0,0],[40,10,0]]\n" +
                       "[[face]]\nname = \"wall\"\nloops = [[\"low\"], [\"high\"]]\n"
                       "annulus = true\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.out << r.err);
  std::vector<std::string> apart;
  const auto j = report(c, "out");
  for (const auto& f : j["network"]["diagnostics"])
    if (f["kind"] == "disconnected") apart.push_back(f["curves"][0]);
  CHECK(apart == std::vector<std::string>{"far"});
}

TEST_CASE("noisy curves of a network are faired unless they are to be kept", "[apps][network]") {
  const CliCase c("network_trembling");
  // A square of 40 whose first side bulges by 8: 41 points with alternating errors of up to 0.15.
  std::string side;
  for (int i = 0; i <= 40; ++i) {
    const double shake = i % 40 == 0 ? 0 : 0.15 * std::sin(12.9898 * i * i);
    side += (i ? ", [" : "[") + std::to_string(i) + ", " +
            std::to_string(-8 * std::sin(i * 3.14159265358979 / 40) + shake) + ", 0]";
  }
  const std::string line = "[[curve]]\nname = ";
  const std::string lines = line + "\"side\"\npoints = [" + side + "]\n" + line +
                            "\"rest\"\npoints = [[40,0,0],[40,40,0],[0,40,0],[0,0,0]]\n";
  c.file("fair.toml", kNetworkHead + lines + kCoarse);
  c.file("keep.toml", kNetworkHead + lines + kCoarse + "[skin]\nnoisy_curves = \"keep\"\n");
  const CliResult fair = c.run({"run", "fair.toml", "--out", "fair"});
  INFO(fair.out << fair.err);
  REQUIRE(fair.code == 0);
  CHECK(fair.out.find("side is noisy and was faired") != std::string::npos);
  const auto curves = report(c, "fair")["faired_curves"];
  REQUIRE(curves.size() == 1);
  CHECK(curves[0]["name"] == "side");
  CHECK(curves[0]["before"]["extrema"].get<int>() >= 10);
  CHECK(curves[0]["after"]["extrema"].get<int>() <= 3);
  CHECK(curves[0]["deviation"]["max"].get<double>() < 0.3);
  const CliResult keep = c.run({"run", "keep.toml", "--out", "keep"});
  CHECK(keep.out.find("faired") == std::string::npos);
  CHECK(!report(c, "keep").contains("faired_curves"));
}

TEST_CASE("skin takes curves from files, in any order", "[apps][network]") {
  const CliCase c("network_files");
  const std::string square =
      "0,0,0\n10,0,0\n\n10,10,0\n0,10,0\n\n0,0,0\n0,10,0\n\n10,10,0\n10,0,0\n";
  c.file("square.csv", square);
  const CliResult r = c.run({"skin", "square.csv", "--unit", "m", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  CHECK(j["unit"] == "m");
  CHECK(j["faces"].size() == 1);
  CHECK(j["surface"]["area"].get<double>() == Approx(100.0));
  CHECK(fs::exists(c / "out/square.step"));
  const CliResult twice = c.run({"skin", "square.csv", "--inner", "x.csv", "--out", "o"});
  CHECK(twice.code == 1);
}

TEST_CASE("curves are written whole although others cut them", "[apps][network]") {
  const CliCase c("network_lines");
  // A wave across a square, intersected by a straight curve in its middle, and a curve with a
  // corner.
  std::string wave = "[[curve]]\nname = \"wave\"\npoints = [";
  for (int i = 0; i <= 40; ++i)
    wave += std::string(i ? "," : "") + "[" + std::to_string(i) + ",20," +
            std::to_string(4 * std::sin(i * std::acos(-1.0) / 40)) + "]";
  c.file("s.toml",
         kNetworkHead +
             "[[curve]]\nname = \"rim\"\npoints = [[0,0,0],[40,0,0],[40,40,0],[0,40,0],[0,0,0]]\n" +
             wave + "]\n[[curve]]\nname = \"spar\"\npoints = [[20,0,0],[20,20,4],[20,40,0]]\n" +
             "corners = \"none\"\n" + kCoarse +
             "[output]\nstep = \"s.step\"\nstep_curves = true\nstep_schema = \"ap242\"\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "first"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  CHECK(report(c, "first")["step"]["faces"] == 4);
  CHECK(report(c, "first")["step"]["curves"] == 6);
  const std::string info = c.run({"info", "first/s.step"}).out;
  INFO(info);
  for (const char* part :
       {"STEP AP242, in mm: 2 products", "part 's', 4 faces", "part 'curves', 6 curves"})
    CHECK(info.find(part) != std::string::npos);
  REQUIRE(c.run({"convert", "first/s.step", "names.csv"}).code == 0);
  const std::string names = contents(c / "names.csv");
  for (const char* name : {",wave\n", ",wave.1\n", ",spar\n", ",rim.1-2\n", ",rim.7-8\n"})
    CHECK(names.find(name) != std::string::npos);
  // The faces of such a file are skinned and fitted again like those of other files.
  const CliResult again =
      c.run({"fit", "first/s.step", "--out", "again", "--fit-tolerance", "0.02", "--step-curves"});
  INFO(again.out << again.err);
  CHECK(again.code == 0);
  CHECK(report(c, "again")["step"]["faces"] == 4);
  CHECK(report(c, "again")["step"]["curves"].get<int>() > 0);
  c.fails(kNetworkHead + box() + "[output]\nstep_curves = true\n", 1,
          {"'step_curves' without 'step'"});
}

namespace {

// A polygon with `sides` sides on a sphere of radius 50, straight in longitude and latitude.
std::string sphere_outline(int sides) {
  std::string csv = "curve,x,y,z\n";
  for (int k = 0; k < sides; ++k)
    for (int i = 0; i <= 16; ++i) {
      const auto at = [&](int c) {
        const double turn = 2 * 3.14159265358979 * c / sides;
        return std::array{0.8 * std::cos(turn), 0.8 * std::sin(turn)};
      };
      const auto a = at(k), b = at(k + 1);
      const double s = i / 16.0, u = (1 - s) * a[0] + s * b[0], v = (1 - s) * a[1] + s * b[1];
      csv += "side" + std::to_string(k);
      for (const double x : {std::sin(u) * std::cos(v), std::sin(v), std::cos(u) * std::cos(v)})
        csv += "," + std::to_string(50 * x);
      csv += "\n";
    }
  return csv;
}

}  // namespace

TEST_CASE("a face with five sides has minimum variation by default, and the summary reports it",
          "[apps][network]") {
  const CliCase c("five_sides");
  c.file("curves.csv", sphere_outline(5));
  const CliResult r = c.run({"skin", "curves.csv", "--out", "out"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  CHECK(r.out.find("1 sphere (radius 50") != std::string::npos);
  CHECK(r.out.find("1 face with five or more sides") != std::string::npos);
  const auto fairing = report(c, "out")["surface"]["fairing"];
  CHECK(fairing["requested"] == false);
  CHECK(fairing["faces"] == 1);
  // fair = "bending" minimises the bending energy instead; four sides need no fairing.
  c.file("s.toml",
         "unit = \"mm\"\n[[curves]]\nfile = \"curves.csv\"\n[skin]\nfair = \"bending\"\n");
  const CliResult bent = c.run({"run", "s.toml", "--out", "bent"});
  CHECK(bent.code == 0);
  CHECK(bent.out.find("sphere") == std::string::npos);
  c.file("curves.csv", sphere_outline(4));
  REQUIRE(c.run({"skin", "curves.csv", "--out", "four"}).code == 0);
  CHECK_FALSE(report(c, "four")["surface"].contains("fairing"));
}

TEST_CASE("normals of a specified face do not depend on its first curve either",
          "[apps][network]") {
  // An arched roof; the alignment of its rib makes it one prescribed face.
  const auto scene = [](bool turned) {
    const std::string front =
        "[[curve]]\nname = \"front\"\npoints = [[0,0,0],[1,0,0.6],[2,0,0.8],[3,0,0.6],[4,0,0]]\n";
    const std::string back =
        "[[curve]]\nname = \"back\"\npoints = [[4,6,0],[3,6,0.6],[2,6,0.8],[1,6,0.6],[0,6,0]]\n";
    const std::string sides =
        "[[curve]]\nname = \"left\"\npoints = [[0,0,0],[0,6,0]]\n"
        "[[curve]]\nname = \"right\"\npoints = [[4,0,0],[4,6,0]]\n";
    const std::string rib =
        "[[curve]]\nname = \"rib\"\nrole = \"inner\"\nalignment = \"embedded\"\n"
        "points = [[0,3,0],[1,3,0.6],[2,3,0.8],[3,3,0.6],[4,3,0]]\n";
    return "unit = \"m\"\n" + (turned ? back + sides + front : front + sides + back) + rib;
  };
  for (const bool turned : {false, true}) {
    const CliCase c("stated_normals");
    c.file("s.toml", scene(turned));
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.out << r.err);
    CHECK(r.out.find("to the convex side") != std::string::npos);
    CHECK(report(c, "out")["surface"]["mean_normal"][2].get<double>() > 0.5);
  }
}

TEST_CASE("a surface that leaves the blend of its curves is named, the default does not",
          "[apps][network]") {
  const CliCase c("departure");
  std::string csv = "curve,x,y,z\n";
  for (const int z : {0, 200})
    for (int i = 0; i <= 24; ++i) {
      const double turn = 2 * 3.14159265358979 * i / 24;
      csv += (z == 0 ? "low," : "high,") + std::to_string(20 * std::cos(turn)) + "," +
             std::to_string(20 * std::sin(turn)) + "," + std::to_string(z) + "\n";
    }
  c.file("c.csv", csv);
  const std::string head = "unit = \"mm\"\n[[curves]]\nfile = \"c.csv\"\n";
  c.file("auto.toml", head);
  c.file("bent.toml", head + "[skin]\nfair = \"bending\"\n");
  const CliResult plain = c.run({"run", "auto.toml", "--out", "out"});
  CHECK(plain.code == 0);
  CHECK((plain.out + plain.err).find("deviates from the blend") == std::string::npos);
  const CliResult bent = c.run({"run", "bent.toml", "--out", "bent"});
  INFO(bent.out << bent.err);
  CHECK((bent.out + bent.err).find("deviates from the blend of its boundary curves") !=
        std::string::npos);
  CHECK((bent.out + bent.err).find("depth of its sections") != std::string::npos);
}
