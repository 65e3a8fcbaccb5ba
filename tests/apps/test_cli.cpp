// SPDX-License-Identifier: MPL-2.0
// Tests of the command line as users call it: every case runs batten itself.
#include "batten/tests/apps/cli_case.h"

#include <signal.h>

#include <cmath>
#include <thread>

#include "batten/apps/cli/process.h"
#include "batten/scenes/runs/run_support.h"

using namespace batten_test;

namespace {

std::string line(const std::string& name, const std::string& points) {
  return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points + "]\n";
}

/// A square of four curves, 100 wide.
std::string square() {
  return line("south", "[0,0,0], [100,0,0]") + line("east", "[100,0,0], [100,100,0]") +
         line("north", "[100,100,0], [0,100,0]") + line("west", "[0,100,0], [0,0,0]");
}
const std::string kUnit = "unit = \"mm\"\n";
const std::string kCoarse = "[mesh]\nedge_length = 30\n";
const std::string kPressure =
    "[[load]]\nname = \"crown\"\ntype = \"pressure\"\nvalue = 5\nmin = -1e9\nmax = 1e9\n";

}  // namespace

TEST_CASE("run makes the outputs of the scene and reports them", "[apps][cli]") {
  const CliCase c("run");
  c.file("s.toml", kUnit + square() + kCoarse + kPressure + R"(
[[constraint]]
name = "peak"
type = "point"
at = [50, 50, 0]
to = [50, 50, 12]
[stress]
thickness = 1
young = 210000
supports = [{curve = "south"}, {curve = "north", type = "pinned"}]
[output]
step = "s.step"
step_form = "exact"
vtp = "s.vtp"
vtu = "s.vtu"
calculix = "s.inp"
)");
  const CliResult r = c.run({"run", "s.toml", "--out", "a/b"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(r.out.find("  normals     point to the convex side\n") != std::string::npos);
  CHECK(r.out.find("  displaced   by up to ") != std::string::npos);
  if (BATTEN_TEST_CGAL) CHECK(r.err.empty());  // without CGAL there is a warning
  for (const char* name : {"s.step", "s.vtp", "s.vtu", "s.inp", "report.json"}) {
    CHECK(fs::file_size(c / ("a/b/" + std::string(name))) > 100);
    CHECK(r.out.find(name) != std::string::npos);
  }
  CHECK(std::distance(fs::directory_iterator(c / "a/b"), fs::directory_iterator()) == 5);

  const auto json = report(c, "a/b");
  CHECK(json["failed_checks"].empty());
  CHECK(json["curves"]["count"] == 4);
  const auto& s = json["surface"];
  CHECK(s["max_curve_residual"] < 1e-10);
  CHECK(s["max_constraint_residual"] < 1e-10);
  CHECK(s["area"] > 10000);  // the square plus the bulge
  CHECK(s["area"] < 12000);
  CHECK(s["size"] == Approx(100 * std::sqrt(2.0)));
  CHECK(json["step"]["valid"] == true);
  CHECK(json["step"]["faces"] == 3 * s["triangles"].get<int>());
  CHECK(json["step"]["max_gap"] < 1e-9 * s["size"].get<double>());
  // Equilibrium: the reactions balance the pressure.
  bool peak = false;
  for (const auto& reaction : json["reactions"]) peak |= reaction["name"] == "peak";
  CHECK(peak);
}

TEST_CASE("a parameter set on the command line changes the shape", "[apps][cli]") {
  const CliCase c("set");
  c.file("s.toml", kUnit + square() + kCoarse + kPressure);
  REQUIRE(c.run({"run", "s.toml", "--out", "a"}).code == 0);
  REQUIRE(c.run({"run", "s.toml", "--out", "b", "--set", "crown=0"}).code == 0);
  REQUIRE(c.run({"run", "s.toml", "--out", "c", "--set", "beta=2", "--set", "crown=10", "--quiet",
                 "--threads", "1"})
              .code == 0);
  const double a = report(c, "a")["surface"]["area"], b = report(c, "b")["surface"]["area"];
  CHECK(a > 10000 * (1 + 1e-9));
  CHECK(b == Approx(10000).epsilon(1e-12));
  // Twice the stiffness under twice the load gives the same shape.
  CHECK(report(c, "c")["surface"]["area"].get<double>() == Approx(a).epsilon(1e-9));
  CHECK(report(c, "c")["parameters"][0]["value"] == 10);
}

TEST_CASE("the same scene in metres is the same shape", "[apps][cli]") {
  const CliCase c("units");
  c.file("mm.toml",
         kUnit + "[[curve]]\nname = \"rim\"\nfile = \"rim.csv\"\n" + kCoarse + kPressure);
  c.file("m.toml",
         "unit = \"m\"\n[[curve]]\nname = \"rim\"\nfile = \"rim.csv\"\nunit = \"mm\"\n"
         "[mesh]\nedge_length = 0.03\n" +
             kPressure);
  c.file("rim.csv", "x,y,z\n0,0,0\n100,0,0\n100,100,5\n0,100,0\n0,0,0\n");
  REQUIRE(c.run({"run", "mm.toml", "--out", "mm"}).code == 0);
  REQUIRE(c.run({"run", "m.toml", "--out", "m"}).code == 0);
  const auto mm = report(c, "mm")["surface"], m = report(c, "m")["surface"];
  CHECK(m["triangles"] == mm["triangles"]);
  CHECK(m["area"].get<double>() == Approx(1e-6 * mm["area"].get<double>()).epsilon(1e-9));
}

TEST_CASE("the pentagon of 1991 rises to its reference height", "[apps][cli]") {
  const CliCase c("pentagon");
  std::string scene = "unit = \"m\"\n";
  for (int k = 0; k < 5; ++k) {
    const auto corner = [](int i) {
      const double angle = (90 + 72 * i) * std::acos(-1.0) / 180;
      std::ostringstream text;
      text.precision(17);
      text << "[" << std::cos(angle) << "," << std::sin(angle) << ",0]";
      return text.str();
    };
    scene += line("side" + std::to_string(k), corner(k) + "," + corner(k + 1));
  }
  c.file("s.toml", scene + R"(
[skin]
boundary = "corners"
alpha = 1
load_units = "absolute"

[mesh]
element = "z12"
mesher = "fan"
refine = 0
[[load]]
name = "lift"
type = "uniform"
direction = [0, 0, 1]
value = 1
[stress]
thickness = 1
young = 1
supports = [{curve = "side0"}]
[output]
calculix = "s.inp"
)");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto s = report(c, "out")["surface"];
  CHECK(s["triangles"] == 5);
  CHECK(s["dofs"] == 28);
  CHECK(s["boundary"] == "corners");

  double gold = 0;
  const auto reference = batten_test::reference("pentagon.json");
  for (const auto& gold_case : reference["cases"])
    if (gold_case["element"] == "Z12" && gold_case["quadrature"] == "exact" &&
        gold_case["alpha"] == 1 && gold_case["beta"] == 1)
      gold = gold_case["centre_z"];
  REQUIRE(gold > 0);
  // The deck is text: rows "node, x, y, z", among them the centre.
  bool found = false;
  std::istringstream deck(contents(c / "out/s.inp"));
  for (std::string row; std::getline(deck, row);) {
    int node = 0;
    double x = 1, y = 1, z = 0;
    if (std::sscanf(row.c_str(), "%d , %lf , %lf , %lf", &node, &x, &y, &z) != 4) continue;
    if (std::hypot(x, y) > 1e-9) continue;
    found = true;
    CHECK(z == Approx(gold).epsilon(1e-8));  // the domain's polygon is computed iteratively
  }
  CHECK(found);
}

TEST_CASE("skin makes a surface directly from files of curves", "[apps][cli]") {
  const CliCase c("skin");
  c.file("rim.csv", "0 0 0\n10 0 1\n10 10 0\n0 10 1\n0 0 0\n");
  c.file("keel.txt", "5 0 0.5\n5 5 1\n5 10 0.5\n");
  const CliResult r = c.run(
      {"skin", "rim.csv", "--out", "out", "--unit", "cm", "--edge-length", "2", "--pressure", "1"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(fs::exists(c / "out/rim.step"));
  CHECK(fs::exists(c / "out/rim.vtp"));
  const auto json = report(c, "out");
  CHECK(json["unit"] == "cm");
  CHECK(json["step"]["valid"] == true);
  CHECK(json["parameters"][0]["name"] == "pressure");

  const CliResult keel = c.run({"skin", "rim.csv", "--inner", "keel.txt", "--out", "keel"});
  INFO(keel.err);
  if (BATTEN_TEST_CGAL) {
    CHECK(keel.code == 0);
    CHECK(report(c, "keel")["curves"]["count"] == 5);
  } else {
    CHECK(keel.code == 1);
    CHECK(keel.err.find("the fan mesher does not support inner curves") != std::string::npos);
  }

  const CliResult info = c.run({"info", "out/rim.step"});
  CHECK(info.code == 0);
  CHECK(info.out.find(" faces in 1 shell") != std::string::npos);
  CHECK(info.out.find("valid") != std::string::npos);
}

TEST_CASE("info lists curves, lengths and parameters", "[apps][cli]") {
  const CliCase c("info");
  c.file("s.toml", kUnit + square() + kPressure);
  const CliResult scene = c.run({"info", "s.toml"});
  CHECK(scene.code == 0);
  CHECK(scene.out.find("south  length 100  from (0, 0, 0) to (100, 0, 0)") != std::string::npos);
  CHECK(scene.out.find("crown = 5  (from -1e+09 to 1e+09)") != std::string::npos);
  c.file("rim.csv", "0 0\n3 4\n\n3 4\n3 5\n");
  const CliResult lines = c.run({"info", "rim.csv"});
  CHECK(lines.code == 0);
  CHECK(lines.out.find("2 curves") != std::string::npos);
  CHECK(lines.out.find("rim_1  length 5  from (0, 0, 0) to (3, 4, 0)") != std::string::npos);
  const CliResult none = c.run({"info", "rum.csv"});
  CHECK(none.code == 1);
  CHECK(none.err.find("rum.csv: found no such file") != std::string::npos);
}

TEST_CASE("choices of a network are drawn, or nothing is where there is no display",
          "[apps][cli]") {
  const CliCase c("choices");
  c.file("rim.csv", "0 0\n3 4\n\n3 4\n3 5\n");
  const CliResult r = c.run({"info", "rim.csv", "--alternatives", "out"});
  CHECK(r.code == 1);
  CHECK(r.err.find("no display") != std::string::npos);
  CHECK_FALSE(fs::exists(c / "out"));
}

TEST_CASE("old options are refused with their new names", "[apps][cli]") {
  const CliCase c("old_options");
  c.file("rim.csv", "0 0 0\n10 0 1\n10 10 0\n0 10 1\n0 0 0\n");
  const auto refused = [&](const std::vector<std::string>& words, const std::string& message) {
    const CliResult r = c.run(words);
    CHECK(r.code == 1);
    CHECK(r.err == "batten: " + message + "\n");
  };
  refused({"fair", "rim.csv", "--out", "a.csv", "--hold-ends"},
          "found the old option --hold-ends, expected --fix-ends");
  refused({"fair", "rim.csv", "--out", "a.csv", "--minimum=energy"},
          "found the old option --minimum, expected --minimize bending or --minimize variation");
  refused({"info", "rim.csv", "--choices", "out"},
          "found the old option --choices, expected --alternatives");
  refused({"fit", "rim.csv", "--lines", "rim.csv", "--out", "out"},
          "found the old option --lines, expected --curves");
  refused({"skin", "rim.csv", "--tolerance", "0.1", "--out", "out"},
          "found the old option --tolerance, expected --fit-tolerance");
  refused({"skin", "rim.csv", "--network", "--out", "out"},
          "found the old option --network, expected none: faces are always detected");
  CHECK(c.run({"skin", "rim.csv", "--netwrok", "--out", "out"}).err.find("--netwrok") !=
        std::string::npos);
}

TEST_CASE("help and version", "[apps][cli]") {
  const CliCase c("help");
  const CliResult help = c.run({"--help"});
  CHECK(help.code == 0);
  CHECK(help.out.find("batten run examples/05-door/scene.toml --out out/door") !=
        std::string::npos);
  const CliResult version = c.run({"--version"});
  CHECK(version.code == 0);
  CHECK(version.out.find("batten ") == 0);
  CHECK(version.out.find("CGAL") != std::string::npos);
  CHECK(c.run({}).code == 1);
  CHECK(c.run({"rnu"}).code == 1);
  CHECK(c.run({"run", "s.toml"}).code == 1);
}

TEST_CASE("curves that form no outline are refused with the reason", "[apps][cli]") {
  const CliCase c("lines");
  const auto refused = [&](const std::string& lines, const std::vector<std::string>& parts) {
    c.fails(kUnit + lines + kCoarse, 1, parts);
  };
  SECTION("open loop") {
    refused(line("a", "[0,0,0],[100,0,0]") + line("b", "[100,0,0],[100,100,0]") +
                line("c", "[100,100,0],[0,100,0]"),
            {"found no closed loop of curves", "'a'", "is not connected to any other curve"});
  }
  SECTION("a segment without length") {
    refused(line("a", "[0,0,0],[100,0,0],[100,0,0],[100,100,0],[0,0,0]"), {"s.toml:4:10: ", "'a'"});
  }
  SECTION("a point twice in a file") {
    c.file("a.csv", "0,0,0\n100,0,0\n100,0,0\n100,100,0\n0,0,0\n");
    refused("[[curve]]\nname = \"a\"\nfile = \"a.csv\"\n",
            {"a.csv:1:1: ", "'a'", "points 2 and 3", "(100, 0, 0)"});
  }
  SECTION("not a number in a file") {
    c.file("a.csv", "0,0,0\n100,nan,0\n100,100,0\n0,0,0\n");
    refused("[[curve]]\nname = \"a\"\nfile = \"a.csv\"\n", {"a.csv:2:"});
  }
  SECTION("not a number in the scene") {
    refused(line("a", "[0,0,0],[100,nan,0],[0,100,0]"), {"s.toml:4:24: found nan"});
  }
  SECTION("all lines on one line") {
    refused(line("a", "[0,0,0],[50,0,0]") + line("b", "[50,0,0],[100,0,0]") +
                line("c", "[100,0,0],[0,0,0]"),
            {"s.toml:"});
  }
  SECTION("a file that is missing") {
    refused("[[curve]]\nname = \"a\"\nfile = \"a.csv\"\n",
            {"s.toml:4:8: ", "a.csv: found no such file"});
  }
  SECTION("a file of an unknown kind") {
    c.file("a.doc", "x");
    refused("[[curve]]\nname = \"a\"\nfile = \"a.doc\"\n",
            {"s.toml:4:8: found the extension '.doc'"});
  }
  SECTION("an empty file") {
    c.file("a.csv", "");
    refused("[[curve]]\nname = \"a\"\nfile = \"a.csv\"\n", {"a.csv"});
  }
  SECTION("a file of two lines where one is asked for") {
    c.file("a.csv", "0,0,0\n1,0,0\n\n1,0,0\n1,1,0\n");
    refused("[[curve]]\nname = \"a\"\nfile = \"a.csv\"\n",
            {"s.toml:4:8: found 2 curves in 'a.csv', expected one for the curve 'a'"});
  }
  SECTION("a name that the file does not have") {
    c.file("a.csv", "0,0,0\n1,0,0\n\n1,0,0\n1,1,0\n");
    refused("[[curves]]\nfile = \"a.csv\"\nonly = [\"a_3\"]\n",
            {"s.toml:4:9: found the curve name 'a_3'", "a_1, a_2", "did you mean 'a_1'?"});
  }
}

TEST_CASE("CAD files that are cut short are refused", "[apps][cli]") {
  const CliCase c("cad");
  const std::string start =
      "                                                                        S      1\n"
      "1H,,1H;,,,,32,38,6,308,15,,1.,2,2HMM,1,0.01,13H240101.000000,1.E-7,100.,G      1\n"
      "     110       1       0       0       0       0       0       000000000D      1\n";
  c.file("a.iges", start);
  c.fails(kUnit + "[[curves]]\nfile = \"a.iges\"\n", 1, {"a.iges"});
  c.file("b.step", "ISO-10303-21;\nHEADER;\n");
  c.fails(kUnit + "[[curves]]\nfile = \"b.step\"\n", 1, {"b.step"});
  c.file("c.iges", "");
  c.fails(kUnit + "[[curves]]\nfile = \"c.iges\"\n", 1, {"c.iges", "empty"});
  c.fails(kUnit + "[[curves]]\nfile = \"c.iges\"\nunit = \"mm\"\n", 1,
          {"s.toml:3:8: found a unit for 'c.iges'"});
  c.file("c.iges", start);
  const auto real = batten_test::optional_data("lines-ship-iges/wigley.iges");
  if (real.empty()) {
    WARN("the whole IGES file is not here: its truncation is not tested");
    return;
  }
  const std::string whole = contents(real);
  c.file("w.iges", whole.substr(0, whole.size() / 2));
  c.fails(kUnit + "[[curves]]\nfile = \"w.iges\"\n", 1, {"w.iges"});
}

TEST_CASE("wrong scenes end with exit code 1", "[apps][cli]") {
  const CliCase c("scenes");
  c.fails(kUnit + square() + "[mesh]\nedge_lenght = 3\n", 1,
          {"s.toml:15:1: found key 'edge_lenght' in [mesh]", "did you mean 'edge_length'?"});
  c.fails("", 1, {"s.toml:1:1: found an empty file"});
  c.fails("unit = mm", 1, {"s.toml:1:8: not TOML"});
  const CliResult missing = c.run({"run", "t.toml", "--out", "out"});
  CHECK(missing.code == 1);
  CHECK(missing.err.find("t.toml: found no such file") != std::string::npos);
  const std::string good = kUnit + square() + kCoarse + kPressure;
  c.fails(good, 1, {"--set crwn=3: found parameter 'crwn'", "did you mean 'crown'?"},
          {"--set", "crwn=3"});
  c.fails(good, 1,
          {"--set crown=2e9: found 2e+09 for 'crown', expected a number from -1e+09 to 1e+09"},
          {"--set", "crown=2e9"});
  c.fails(good, 1, {"--set crown: found no '='"}, {"--set", "crown"});
  c.fails(good, 1, {"--set crown=high: found 'high', expected a number"}, {"--set", "crown=high"});
  c.fails(
      good + "[[constraint]]\nname = \"east\"\ntype = \"point\"\nat = [50,50,0]\nto = [50,50,1]\n",
      1, {"s.toml:23:8: the name 'east' is already used"});
  c.fails(good +
              "[stress]\nthickness = 1\nyoung = 1\nsupports = [{curve = \"suoth\"}]\n[output]\n"
              "calculix = \"s.inp\"\n",
          1, {"found the curve 'suoth'", "did you mean 'south'?"});
}

TEST_CASE("an output folder that cannot be is refused before the work", "[apps][cli]") {
  const CliCase c("folder");
  c.file("s.toml", kUnit + square() + kCoarse);
  c.file("plain", "not a folder");
  const CliResult below = c.run({"run", "s.toml", "--out", "plain/out"});
  CHECK(below.code == 1);
  CHECK(below.err.find("plain/out: cannot use this output folder") != std::string::npos);
  const CliResult itself = c.run({"run", "s.toml", "--out", "plain"});
  CHECK(itself.code == 1);
  CHECK(contents(c / "plain") == "not a folder");
}

TEST_CASE("constraints in conflict are named", "[apps][cli]") {
  const CliCase c("conflict");
  const auto point = [](const std::string& name, const std::string& to) {
    return "[[constraint]]\nname = \"" + name + "\"\ntype = \"point\"\nat = [50,50,0]\nto = " + to +
           "\n";
  };
  const std::string scene = kUnit + square() + kCoarse;
  c.fails(scene + point("up", "[50,50,10]") + point("down", "[50,50,-10]"), 2, {"'up'", "'down'"});
  c.fails(
      scene + "[[constraint]]\nname = \"pull\"\ntype = \"point\"\nat = [100,0,0]\nto = [0,0,1]\n",
      2, {"'pull'", "'south'"});
}

TEST_CASE("a pressure past its limit has no solution", "[apps][cli]") {
  const CliCase c("limit");
  c.fails(kUnit + square() + kCoarse + kPressure, 3, {"load limit exceeded", "crown"},
          {"--set", "crown=1e8"});
}

TEST_CASE("a run that fails leaves the files of the run before", "[apps][cli]") {
  const CliCase c("before");
  c.file("s.toml", kUnit + square() + kCoarse + kPressure + "[output]\nvtp = \"s.vtp\"\n");
  REQUIRE(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  const std::string vtp = contents(c / "out/s.vtp"), json = contents(c / "out/report.json");
  REQUIRE(c.run({"run", "s.toml", "--out", "out", "--set", "crown=1e8"}).code == 3);
  CHECK(contents(c / "out/s.vtp") == vtp);
  CHECK(contents(c / "out/report.json") == json);
  CHECK(std::distance(fs::directory_iterator(c / "out"), fs::directory_iterator()) == 2);
}

TEST_CASE("the same scene gives the same files", "[apps][cli]") {
  const CliCase c("same");
  c.file("s.toml", kUnit + square() + kCoarse + kPressure + "[output]\nvtp = \"s.vtp\"\n");
  REQUIRE(c.run({"run", "s.toml", "--out", "a", "--threads", "1"}).code == 0);
  REQUIRE(c.run({"run", "s.toml", "--out", "b", "--threads", "2"}).code == 0);
  CHECK(contents(c / "a/s.vtp") == contents(c / "b/s.vtp"));
  auto a = report(c, "a"), b = report(c, "b");
  a.erase("timings_s");
  b.erase("timings_s");
  CHECK(a == b);
}

TEST_CASE("without a display everything but the pictures is made", "[apps][cli]") {
  const CliCase c("display");
  c.file("s.toml",
         kUnit + square() + kCoarse + "[output]\nvtp = \"s.vtp\"\n[[picture]]\nfile = \"s.png\"\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  CHECK(r.code == 4);
  CHECK(r.err.find("check failed: s.png is not drawn: no display") != std::string::npos);
  CHECK(fs::exists(c / "out/s.vtp"));
  CHECK_FALSE(fs::exists(c / "out/s.png"));
  CHECK(report(c, "out")["failed_checks"][0]["check"] == "s.png");
  const CliResult view = c.run({"view", "s.toml", "--screenshot", "v.png"});
  CHECK(view.code == 1);
  CHECK(view.err.find("no display") != std::string::npos);
  CHECK_FALSE(fs::exists(c / "v.png"));
}

TEST_CASE("a failed check is a failure, with name and amount", "[apps][cli]") {
  const CliCase c("promise");
  // A normal that makes the surface vertical at one vertex folds it.
  c.file("s.toml", kUnit + square() + kCoarse +
                       "[[constraint]]\nname = \"edge on\"\ntype = \"normal\"\nat = [50,50,0]\n"
                       "direction = [1,0,0]\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  CHECK(r.code == 4);
  CHECK(r.err.find("check failed: faces.s.min_jacobian_ratio is ") != std::string::npos);
  CHECK(r.err.find("expected at least 0.05") != std::string::npos);
  CHECK(fs::exists(c / "out/report.json"));
}

namespace {

// Waits until a process that runs has created its temporary folder, which is not `known`.
fs::path wait_for_folder(const fs::path& out, pid_t child, const fs::path& known) {
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    std::error_code error;
    for (fs::directory_iterator entry(out, error), end; !error && entry != end;
         entry.increment(error))
      if (entry->path().filename().string().starts_with(".batten.") && entry->path() != known)
        return entry->path();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return {};
}

}  // namespace

TEST_CASE("an interrupted run leaves nothing", "[apps][cli]") {
  for (const int signal : {SIGINT, SIGTERM}) {
    const CliCase c("interrupt");
    // Takes far longer than the wait below; the hidden folder shows that it has started.
    c.file("s.toml", kUnit + square() + "[mesh]\nedge_length = 0.3\n" + kPressure +
                         "[output]\nstep = \"s.step\"\n");
    const pid_t child = c.start({"run", "s.toml", "--out", "out"});
    wait_for_folder(c / "out", child, {});
    kill(child, signal);
    const CliResult r = c.wait(child);
    INFO(r.err);
    CHECK(r.code == 130);
    CHECK(r.err == "batten: cancelled\n");
    CHECK_FALSE(fs::exists(c / "out"));
  }
}

TEST_CASE("files of a killed run are removed by the next, those of a running one are not",
          "[apps][cli]") {
  const CliCase c("killed");
  c.file("s.toml", kUnit + square() + "[mesh]\nedge_length = 0.3\n" + kPressure);
  c.file("small.toml", kUnit + square());
  const auto begun = [&](const fs::path& known) {
    const pid_t child = c.start({"run", "s.toml", "--out", "out"});
    const fs::path hidden = wait_for_folder(c / "out", child, known);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // it locks the folder
    return std::pair(child, hidden);
  };
  const auto [killed, orphan] = begun({});
  kill(killed, SIGKILL);
  c.wait(killed);
  REQUIRE(fs::exists(orphan));
  const auto [living, hidden] = begun(orphan);
  CHECK_FALSE(fs::exists(orphan));
  CHECK(c.run({"run", "small.toml", "--out", "out"}).code == 0);
  CHECK(fs::exists(hidden));
  CHECK(fs::exists(c / "out/report.json"));
  kill(living, SIGTERM);
  c.wait(living);
  CHECK_FALSE(fs::exists(hidden));
  CHECK(fs::exists(c / "out/report.json"));

  // A single file: a folder of the same operating system that no process has locked.
  const std::string orphan_mark = orphan.extension().string(),
                    half = ".faired.csv" + orphan_mark + "/faired.csv";
  c.file(half, "half");
  c.file(".faired.csv.mine/faired.csv", "somebody's own");
  fs::copy_file(c / half, (c / half).parent_path() / ".lock");
  c.file("wave.csv", "x,y,z\n0,0,0\n1,1,0\n2,0,0\n3,1,0\n");
  CHECK(c.run({"fair", "wave.csv", "--out", "faired.csv"}).code == 0);
  CHECK_FALSE(fs::exists(c / half));
  CHECK(fs::exists(c / ".faired.csv.mine/faired.csv"));
}

TEST_CASE("work that does not respond to cancellation is ended all the same", "[apps][cli]") {
  const CliCase c("deaf");
  const pid_t child = fork();
  if (child == 0) {
    batten::catch_interrupts();
    close(STDERR_FILENO);
    const batten::OutputFolder out(c / "a/out");
    write(out.file("half.txt"), "half");
    fs::create_directory(out.file("pictures"));
    const batten::AtomicFile whole(c / "whole.txt");
    raise(SIGTERM);
    for (;;) pause();
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 130);
  c.file("other.txt", "");
  CHECK(std::distance(fs::directory_iterator(c / ""), fs::directory_iterator()) == 1);
}

TEST_CASE("the name of a file is no output folder", "[apps][cli]") {
  const CliCase c("out_file");
  c.file("plate.csv", "0,0,0\n10,0,0\n10,10,0\n0,10,0\n0,0,0\n");
  const CliResult r = c.run({"skin", "plate.csv", "--out", "plate.step"});
  CHECK(r.code != 0);
  CHECK_THAT(r.err, Catch::Matchers::Contains("'plate.step', expected a folder, such as 'plate'"));
  CHECK_FALSE(fs::exists(c / "plate.step"));
  // Other dots are part of a name, and folders that exist are folders.
  fs::create_directories(c / "old.step");
  for (const char* folder : {"v1.2", "old.step"})
    CHECK(c.run({"skin", "plate.csv", "--out", folder}).code == 0);
}
