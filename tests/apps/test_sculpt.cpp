// SPDX-License-Identifier: MPL-2.0
// batten sculpt: solve, sweep, move, refine, record and replay.
#include <cmath>
#include <regex>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

std::string line(const std::string& name, const std::string& points) {
  return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points + "]\n";
}

/// A square of four curves, 100 wide; the fan mesher does not need CGAL.
const std::string kSquare =
    "unit = \"mm\"\nname = \"my square\"\n" + line("south", "[0,0,0], [100,0,0]") +
    line("east", "[100,0,0], [100,100,0]") + line("north", "[100,100,0], [0,100,0]") +
    line("west", "[0,100,0], [0,0,0]") +
    "[mesh]\nmesher = \"fan\"\nedge_length = 30\n[skin]\nalpha = 1\nbeta = 0.01\n";
const std::string kSwell =
    "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = 0.4\nmin = 0\nmax = 1000\n";
const std::string kOutput = "[output]\nvtp = \"s.vtp\"\nstep = \"s.step\"\n";

int lines_in(const std::string& text, const std::string& word) {
  int n = 0;
  for (size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

/// An independent reader: XML, and VTK for each file.
const char* const kReader = R"(
import os, sys, xml.etree.ElementTree as tree
import vtk
folder = os.path.dirname(sys.argv[1])
for data in tree.parse(sys.argv[1]).getroot().iter('DataSet'):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(os.path.join(folder, data.get('file')))
    reader.Update()
    box = reader.GetOutput().GetBounds()
    print(float(data.get('timestep')), reader.GetOutput().GetNumberOfPolys(), box[5])
)";

/// Without a display, only the check of the pictures fails.
bool only_pictures_failed(const nlohmann::json& report) {
  for (const auto& missed : report["failed_checks"])
    if (missed["detail"].get<std::string>().find("not drawn") == std::string::npos) return false;
  return true;
}

}  // namespace

TEST_CASE("sculpt solves and writes the same as run", "[apps][sculpt]") {
  const CliCase c("sculpt_static");
  c.file("s.toml", kSquare + kSwell + kOutput);
  const CliResult r = c.run({"sculpt", "s.toml", "--out", "live"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  for (const char* name : {"s.step", "s.vtp", "report.json"})
    CHECK(fs::exists(c / ("live/" + std::string(name))));
  CHECK(r.out.find("energy") != std::string::npos);
  REQUIRE(c.run({"run", "s.toml", "--out", "static"}).code == 0);
  const auto live = report(c, "live"), still = report(c, "static");
  CHECK(live["failed_checks"].empty());
  CHECK(live["surface"]["dofs"] == still["surface"]["dofs"]);
  for (const char* key : {"area", "bending_energy"})
    CHECK(live["surface"][key].get<double>() ==
          Approx(still["surface"][key].get<double>()).epsilon(1e-8));
  const auto& s = live["sculpting"];
  CHECK(s["area"].get<double>() == Approx(live["surface"]["area"].get<double>()).epsilon(1e-3));
  CHECK(s["volume"].get<double>() > 0);
  CHECK(s["residual"].get<double>() < 1e-10);
  CHECK(s["updates"][0]["operation"] == "solve");
}

TEST_CASE("a session finds the same points as run, and the same shape", "[apps][sculpt]") {
  const CliCase c("sculpt_places");
  // The second position is searched after the first constraint has moved the surface.
  c.file("s.toml", kSquare + kSwell + R"(
[[load]]
name = "side"
type = "point"
value = 0.1
direction = [0, 1, 1]
at = [60, 70, 3]
[[constraint]]
name = "peak"
type = "point"
at = [50, 50, 0]
to = [55, 50, 30]
[[constraint]]
name = "near it"
type = "point"
at = [70, 50, 10]
to = [72, 50, 14]
range = 3
)");
  for (const char* command : {"run", "sculpt"})
    REQUIRE(c.run({command, "s.toml", "--out", command}).code == 0);
  const auto still = report(c, "run"), live = report(c, "sculpt");
  CHECK(live["surface"]["bending_energy"].get<double>() ==
        Approx(still["surface"]["bending_energy"].get<double>()).epsilon(1e-8));
  CHECK(live["surface"]["area"].get<double>() ==
        Approx(still["surface"]["area"].get<double>()).epsilon(1e-10));
}

TEST_CASE("run makes scenes that only a session knows", "[apps][sculpt]") {
  const CliCase c("sculpt_run");
  // Painted everywhere near the middle, controlled by one slider: run and sculpt give the same
  // shape.
  c.file("s.toml", kSquare + R"(
[[load]]
name = "bump"
type = "uniform"
value = 0
direction = [0, 0, 1]
paint = [{ at = [50, 50, 0], radius = 40 }]
[[stiffness]]
name = "stiff"
type = "beta"
value = 0.1
near = "south"
radius = 30
parametric_direction = [1, 0]
[[offset]]
name = "shift"
curve = "north"
value = 0
direction = [0, 0, 1]
[[parameter]]
name = "bolder"
value = 1
drives = [{ name = "bump", factor = 0.5 }]
)" + kOutput);
  for (const char* command : {"run", "sculpt"}) {
    const CliResult r = c.run({command, "s.toml", "--out", command});
    INFO(r.err);
    REQUIRE(r.code == 0);
  }
  CHECK(contents(c / "run/s.vtp") == contents(c / "sculpt/s.vtp"));
  double bump = 0;
  const auto json = report(c, "run");
  for (const auto& p : json["parameters"])
    if (p["name"] == "bump") bump = p["value"];
  CHECK(bump == 0.5);
  const double area = json["surface"]["area"];
  CHECK(area > 10001);
  REQUIRE(c.run({"run", "s.toml", "--out", "flat", "--set", "bolder=0"}).code == 0);
  CHECK(report(c, "flat")["surface"]["area"].get<double>() == Approx(10000).epsilon(1e-9));
  REQUIRE(c.run({"sculpt", "s.toml", "--out", "flat2", "--set", "bolder=0"}).code == 0);
  CHECK(report(c, "flat2")["surface"]["area"].get<double>() == Approx(10000).epsilon(1e-9));
  const CliResult info = c.run({"info", "s.toml"});
  CHECK(info.out.find("bolder = 1") != std::string::npos);
  CHECK(info.out.find("bump = 0.5") != std::string::npos);
}

TEST_CASE("an offset embedded curve stays within the tolerance, with small triangles near it only",
          "[apps][sculpt]") {
  if (!BATTEN_TEST_CGAL) return;
  const CliCase c("sculpt_move");
  std::string ring;
  for (int k = 0; k <= 16; ++k) {
    const double a = (k % 16) * std::acos(-1.0) / 8;
    ring += (k > 0 ? ", [" : "[") + std::to_string(70 + 12 * std::cos(a)) + ", " +
            std::to_string(70 + 12 * std::sin(a)) + ", 0]";
  }
  std::string scene = "corner_angle = 60\n" + kSquare;
  const std::string skin =
      "[mesh]\nmesher = \"fan\"\nedge_length = 30\n[skin]\nalpha = 1\nbeta = 0.01\n";
  scene.replace(scene.find(skin), skin.size(),
                line("ring", ring) + "role = \"inner\"\n[mesh]\nedge_length = 12\n");
  c.file("s.toml", scene + "[[offset]]\nname = \"lift\"\ncurve = \"ring\"\nvalue = 5\n");
  for (const char* command : {"run", "sculpt"}) {
    const CliResult r = c.run({command, "s.toml", "--out", command});
    INFO(r.err);
    CHECK(r.code == 0);
  }
  const auto json = report(c, "run");
  for (const auto& each : json["curves"]["each"])
    if (each.contains("gap")) CHECK(each["gap"].get<double>() <= 0.01414);
  CHECK(json["surface"]["area"].get<double>() > 10050);
  CHECK(json["surface"]["triangles"].get<int>() < 2000);
}

TEST_CASE("a sweep is a series of files and a table", "[apps][sculpt]") {
  const CliCase c("sculpt_sweep");
  c.file("s.toml", kSquare + kSwell);
  const CliResult r = c.run({"sculpt", "s.toml", "--out", "out", "--sweep", "swell=0:0.8:5"});
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));
  const auto json = report(c, "out");
  CHECK(only_pictures_failed(json));
  const auto& sweep = json["sculpting"]["sweeps"][0];
  CHECK(sweep["parameter"] == "swell");
  REQUIRE(sweep["rows"].size() == 5);
  CHECK_FALSE(sweep.contains("stopped"));
  double volume = -1;
  for (size_t i = 0; i < 5; ++i) {
    const auto& row = sweep["rows"][i];
    CHECK(row["value"].get<double>() == Approx(0.2 * static_cast<double>(i)).margin(1e-15));
    CHECK(row["volume"].get<double>() > volume);
    CHECK(row["residual"].get<double>() < 1e-10);
    volume = row["volume"];
  }
  // The shape for each value is independent of the others.
  REQUIRE(c.run({"run", "s.toml", "--out", "single", "--set", "swell=0.8"}).code == 0);
  CHECK(sweep["rows"][4]["bending_energy"].get<double>() ==
        Approx(report(c, "single")["surface"]["bending_energy"].get<double>()).epsilon(1e-8));
  const std::string pvd = contents(c / "out/my_square_swell.pvd");
  CHECK(lines_in(pvd, "<DataSet") == 5);
  for (int i = 0; i < 5; ++i) {
    const std::string name = "my_square_swell_00" + std::to_string(i) + ".vtp";
    CHECK(fs::file_size(c / ("out/" + name)) > 1000);
    CHECK(pvd.find("file=\"" + name + "\"") != std::string::npos);
  }
  CHECK(r.out.find("my_square_swell_000.vtp … my_square_swell_004.vtp (5)") != std::string::npos);

  if (std::system("/usr/bin/python3 -c 'import vtk' > /dev/null 2>&1") != 0) {
    WARN("skipped: python3 has no module vtk");
    return;
  }
  c.file("read.py", kReader);
  REQUIRE(std::system(("cd '" + (c / "").string() +
                       "' && /usr/bin/python3 read.py out/my_square_swell.pvd > read.txt")
                          .c_str()) == 0);
  std::istringstream read(contents(c / "read.txt"));
  double value = 0, facets = 0, top = 0, before = -1;
  int count = 0;
  for (; read >> value >> facets >> top; ++count) {
    CHECK(value == Approx(0.2 * count).margin(1e-15));
    CHECK(facets >= 64);
    CHECK(top > before);
    before = top;
  }
  CHECK(count == 5);
}

TEST_CASE("a value past the limit ends its sweep, and the results before it stay",
          "[apps][sculpt]") {
  const CliCase c("sculpt_limit");
  c.file("s.toml", kSquare + kSwell + "[output]\nvtp = \"s.vtp\"\n");
  const CliResult r = c.run({"sculpt", "s.toml", "--out", "out", "--sweep", "swell=0:1000:6"});
  INFO(r.err);
  CHECK(r.code == 4);
  const auto json = report(c, "out");
  const auto& sweep = json["sculpting"]["sweeps"][0];
  CHECK(sweep["rows"].size() >= 1);
  CHECK(sweep["rows"].size() < 6);
  CHECK(sweep["stopped"].get<std::string>().find("reached") != std::string::npos);
  CHECK(fs::exists(c / "out/s_swell_000.vtp"));
  CHECK(r.err.find("sweep of swell") != std::string::npos);
  // The scene's own value is restored at the end.
  REQUIRE(c.run({"sculpt", "s.toml", "--out", "plain"}).code == 0);
  CHECK(json["sculpting"]["area"].get<double>() ==
        Approx(report(c, "plain")["sculpting"]["area"].get<double>()).epsilon(1e-9));

  const CliResult past = c.run({"sculpt", "s.toml", "--out", "none", "--set", "swell=1000"});
  CHECK(past.code == 3);
  CHECK(past.err.find("reached") != std::string::npos);
  CHECK_FALSE(fs::exists(c / "none"));
}

TEST_CASE("a motion is a series in time", "[apps][sculpt]") {
  const CliCase c("sculpt_time");
  c.file("s.toml", kSquare +
                       "[[load]]\nname = \"swell\"\ntype = \"pressure\"\n"
                       "value = [[0, 0], [0.5, 0.4]]\n[motion]\ndensity = 0\ndamping = 0.01\n");
  const CliResult r =
      c.run({"sculpt", "s.toml", "--out", "out", "--time", "1", "--dt", "0.05", "--frames", "10"});
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));
  const auto json = report(c, "out");
  CHECK(only_pictures_failed(json));
  const auto& motion = json["sculpting"]["motion"];
  CHECK(motion["steps"] == 20);
  CHECK(motion["damping"] == 0.01);
  CHECK(motion["max_residual"].get<double>() < 1e-10);
  REQUIRE(motion["rows"].size() == 11);
  for (size_t i = 0; i < 11; ++i)
    CHECK(motion["rows"][i]["time"].get<double>() ==
          Approx(0.1 * static_cast<double>(i)).margin(1e-12));
  CHECK(motion["rows"][0]["volume"].get<double>() == Approx(0).margin(1e-6));
  CHECK(motion["rows"][10]["volume"].get<double>() > motion["rows"][2]["volume"].get<double>());
  CHECK(lines_in(contents(c / "out/my_square_time.pvd"), "<DataSet") == 11);
  CHECK(fs::exists(c / "out/my_square_time_010.vtp"));
}

TEST_CASE("refinement is reported", "[apps][sculpt]") {
  const CliCase c("sculpt_refine");
  c.file("s.toml", kSquare + kSwell);
  const CliResult r = c.run({"sculpt", "s.toml", "--out", "out", "--refine", "jumps:2"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto json = report(c, "out");
  const auto& rounds = json["sculpting"]["refinements"];
  REQUIRE(rounds.size() == 2);
  CHECK(rounds[1]["triangles"].get<int>() > rounds[0]["triangles"].get<int>());
  CHECK(rounds[0]["triangles"].get<int>() > rounds[0]["triangles_before"].get<int>());
  CHECK(json["surface"]["triangles"] == rounds[1]["triangles"]);
  CHECK(json["surface"]["max_constraint_residual"].get<double>() <= 1e-10);
}

TEST_CASE("a recorded session is replayed to the same bytes", "[apps][sculpt]") {
  const CliCase c("sculpt_replay");
  c.file("s.toml", kSquare + kSwell +
                       "[[constraint]]\nname = \"peak\"\ntype = \"point\"\nat = [50, 50, 0]\n"
                       "to = [50, 50, 5]\n[motion]\ndensity = 0.1\ndamping = 0.1\n[output]\n"
                       "vtp = \"s.vtp\"\n");
  const CliResult r = c.run({"sculpt", "s.toml", "--out", "first", "--record", "log.jsonl", "--set",
                             "swell=0.3", "--set", "peak.z=9", "--refine", "jumps:1", "--sweep",
                             "peak.z=0:12:4", "--time", "0.3", "--dt", "0.05"});
  INFO(r.err);
  REQUIRE((r.code == 0 || r.code == 4));
  CHECK(lines_in(contents(c / "log.jsonl"), "\"step\"") == 6);
  const CliResult again = c.run({"sculpt", "s.toml", "--out", "second", "--replay", "log.jsonl"});
  INFO(again.err);
  REQUIRE(again.code == 0);
  CHECK(contents(c / "first/s.vtp") == contents(c / "second/s.vtp"));
  CHECK(contents(c / "first/s.vtp") != contents(c / "first/my_square_time_000.vtp"));

  c.file("log.jsonl", contents(c / "log.jsonl") + "{\"do\":\"steps\"}\n");
  const CliResult bad = c.run({"sculpt", "s.toml", "--out", "third", "--replay", "log.jsonl"});
  CHECK(bad.code == 1);
  CHECK(std::regex_search(bad.err, std::regex("log.jsonl:[0-9]+: .*did you mean 'step'")));
  CHECK_FALSE(fs::exists(c / "third"));
}

TEST_CASE("sculpt refuses wrong options before it starts", "[apps][sculpt]") {
  const CliCase c("sculpt_words");
  const std::string scene = kSquare + kSwell;
  const auto fails = [&](const std::vector<std::string>& more,
                         const std::vector<std::string>& parts) {
    c.fails(scene, 1, parts, more, "sculpt");
  };
  fails({"--sweep", "swell"}, {"--sweep swell: found no name, expected NAME=FROM:TO:COUNT"});
  fails({"--sweep", "swell=1:2"}, {"found 2 numbers, expected NAME=FROM:TO:COUNT"});
  fails({"--sweep", "swell=1:x:3"}, {"found 'x' for a number"});
  fails({"--sweep", "swell=1:2:1"}, {"found 1 values, expected a whole number from 2"});
  fails({"--sweep", "swell=1:1:3"}, {"found an empty range, 1 at both ends"});
  fails({"--sweep", "swel=0:1:3"}, {"--sweep swel=0:1:3: ", "did you mean 'swell'?"});
  fails({"--sweep", "swell=0:2000:3"}, {"found 2000", "from 0 to 1000"});
  fails({"--set", "swell=-1"}, {"--set swell=-1: ", "found -1"});
  fails({"--set", "swell"}, {"found no '='"});
  fails({"--refine", "jump:2"}, {"--refine: found jump:2, expected jumps:ITERATIONS"});
  fails({"--refine", "jumps:0"}, {"expected jumps:ITERATIONS"});
  fails({"--time", "1"}, {"--dt"});
  fails({"--time", "1", "--dt", "0"}, {"--dt"});
  fails({"--time", "1", "--dt", "1e-9"}, {"found 1e+09 time steps, expected at most a million"});
  fails({"--replay", "none.jsonl"}, {"none.jsonl: found no such file"});
  fails({"--replay", "none.jsonl", "--record", "a"}, {"--record"});
  fails({"--record", "none/log.jsonl"}, {"none/log.jsonl"});
  c.fails(kSquare +
              "[[load]]\nname = \"l\"\ntype = \"attractors\"\nvalue = 1\nat = [[0,0,0]]\n"
              "curve = \"rail\"\n",
          1, {"s.toml:", "found the curve 'rail', expected one of: south, east"}, {}, "sculpt");
}
