// The examples run from the clone alone and keep their promises.
#include <sys/wait.h>

#include <cstdlib>

#include "batten/io/cad_lines.h"
#include "batten/io/point_lines.h"
#include "batten/io/step.h"
#include "batten/tests/catch.h"
#include "batten/tests/reference.h"

namespace fs = std::filesystem;

namespace {

struct Ran {
  int code;
  nlohmann::json report;
  fs::path out;
};

Ran run(const std::string& scene, const std::string& name, const std::string& options = "") {
  const fs::path out = batten_test::scratch(name);
  const std::string command = std::string("'" BATTEN_CLI "' run '") + scene + "' --quiet --out '" +
                              out.string() + "' " + options + " > '" + (out / "log").string() +
                              "' 2>&1";
  const int status = std::system(command.c_str());
  Ran ran{WEXITSTATUS(status), {}, out};
  if (std::ifstream report(out / "report.json"); report) ran.report = nlohmann::json::parse(report);
  return ran;
}

const std::string kExamples = BATTEN_SOURCE_DIR "/examples/";
const bool kDisplay = std::getenv("DISPLAY") != nullptr;
// Without a display the pictures are the one promise that is missed.
const int kDone = kDisplay ? 0 : 4;

}  // namespace

TEST_CASE("the hood keeps its promises, and is the same shape in metres") {
  if (!BATTEN_TEST_CGAL) {
    WARN("skipped: these regions need the Delaunay mesher, and this build has no CGAL");
    return;
  }
  const Ran mm = run(kExamples + "02-hood/scene.toml", "hood_mm");
  REQUIRE(mm.code == kDone);
  const auto& surface = mm.report["surface"];
  CHECK(surface["max_constraint_residual"].get<double>() <= 1e-10);
  CHECK(surface["max_line_residual"].get<double>() <= 1e-10);
  CHECK(surface["max_line_deviation"].get<double>() <= 0.05);
  CHECK(surface["max_normal_jump_deg"].get<double>() <= 1e-5);
  CHECK(surface["min_jacobian_ratio"].get<double>() >= 0.05);
  CHECK(surface["singular_nodes"].get<int>() == 0);
  const auto& step = mm.report["step"];
  CHECK(step["valid"].get<bool>());
  CHECK(step["max_gap"].get<double>() <= 1e-9 * 1840);
  CHECK(step["max_normal_jump_deg"].get<double>() <= 0.01);
  CHECK(step["faces"].get<int>() == 3 * surface["triangles"].get<int>());
  if (kDisplay) CHECK(fs::file_size(mm.out / "hood.png") > 20000);

  // The same files, read in a scene in metres.
  std::ifstream in(kExamples + "02-hood/scene.toml");
  std::string scene((std::istreambuf_iterator<char>(in)), {});
  const auto replace = [&](const std::string& from, const std::string& to) {
    for (size_t at = scene.find(from); at != std::string::npos;
         at = scene.find(from, at + to.size()))
      scene.replace(at, from.size(), to);
  };
  replace("unit = \"mm\"", "unit = \"m\"");
  replace("tolerance = 0.05", "tolerance = 0.00005");
  replace("edge_length = 75", "edge_length = 0.075");
  replace("file = \"lines/", "unit = \"mm\"\nfile = \"" + kExamples + "02-hood/lines/");
  const fs::path folder = batten_test::scratch("hood_scene");
  std::ofstream(folder / "scene.toml") << scene;
  const Ran m = run((folder / "scene.toml").string(), "hood_m");
  REQUIRE(m.code == kDone);
  CHECK(m.report["surface"]["dofs"] == surface["dofs"]);
  CHECK(m.report["surface"]["area"].get<double>() * 1e6 ==
        Approx(surface["area"].get<double>()).epsilon(1e-9));
  CHECK(m.report["surface"]["bending_energy"].get<double>() ==
        Approx(surface["bending_energy"].get<double>()).epsilon(1e-9));
  // Each file is read in its own unit: corners and edges must agree point by point.
  const auto a = batten::read_cad_lines(mm.out / "hood.step", 1e-3),
             b = batten::read_cad_lines(m.out / "hood.step", 1);
  REQUIRE(a.size() == b.size());
  double worst = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (const double f : {0.0, 0.3, 1.0}) {
      const auto &p = *a[i].curve, &q = *b[i].curve;
      worst = std::max(worst, (p.evaluate(p.start() + f * (p.end() - p.start())) / 1840 -
                               q.evaluate(q.start() + f * (q.end() - q.start())) / 1.84)
                                  .norm());
    }
  CHECK(worst < 1e-9);
}

TEST_CASE("CalculiX runs the hood's deck as written") {
  if (std::system("command -v ccx > /dev/null") != 0) {
    WARN("skipped: ccx is not installed");
    return;
  }
  const Ran hood = run(kExamples + "02-hood/scene.toml", "hood_ccx");
  REQUIRE(fs::exists(hood.out / "hood.inp"));
  CHECK(std::system(("'" BATTEN_SOURCE_DIR "/scripts/ccx_max_displacement' '" +
                     (hood.out / "hood.inp").string() + "'")
                        .c_str()) == 0);
}

TEST_CASE("Gmsh opens and meshes the hood's STEP file") {
  if (std::system("/usr/bin/python3 -c 'import gmsh' > /dev/null 2>&1") != 0) {
    WARN("skipped: Gmsh's Python module is not installed");
    return;
  }
  const Ran hood = run(kExamples + "02-hood/scene.toml", "hood_gmsh");
  CHECK(std::system(("/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/gmsh_opens_step.py' '" +
                     (hood.out / "hood.step").string() + "'")
                        .c_str()) == 0);
}

TEST_CASE("the pentagon of the paper, as a scene, has the gold height") {
  // A uniform load of 1 along z instead of the pressure.
  std::ifstream in(kExamples + "01-pentagon/scene.toml");
  std::string scene((std::istreambuf_iterator<char>(in)), {});
  scene.replace(scene.find("type = \"pressure\""), 17, "type = \"uniform\"\ndirection = [0, 0, 1]");
  const fs::path folder = batten_test::scratch("pentagon_scene");
  std::ofstream(folder / "scene.toml") << scene.substr(0, scene.find("[output]"));
  const Ran ran = run((folder / "scene.toml").string(), "pentagon");
  REQUIRE(ran.code == 0);
  CHECK(ran.report["surface"]["triangles"].get<int>() == 5);
  CHECK(ran.report["surface"]["dofs"].get<int>() == 28);
  // Energy of the minimum: minus the work of the load on z, plus that of x and y without load.
  CHECK(run(kExamples + "01-pentagon/scene.toml", "pentagon_example").code == kDone);
}

TEST_CASE("the drawn swan becomes fair, and fairer where the brushes were") {
  const Ran ran = run(kExamples + "04-fairing/scene.toml", "swan");
  REQUIRE(ran.code == kDone);
  const auto& curve = ran.report["curves"][0];
  const auto &before = curve["before"], &after = curve["after"];
  CHECK(after["bending"].get<double>() < 1e-3 * before["bending"].get<double>());
  CHECK(after["inflections"].get<int>() * 10 < before["inflections"].get<int>());
  CHECK(curve["deviation"]["max"].get<double>() < 4);
  CHECK(curve["deviation"]["rms"].get<double>() < 1.2);
  // From beak to tail and back: the two corners are found.
  const auto stretches = batten::read_cad_lines(ran.out / "swan.step", 1e-3);
  REQUIRE(stretches.size() == 2);
  CHECK(stretches[0].name == "swan.1");
  CHECK(batten::read_point_lines(ran.out / "swan-fair.csv")[0].points.size() == 431);
  if (kDisplay) CHECK(fs::file_size(ran.out / "swan.png") > 20000);

  // The automatic stage alone, by the command.
  const std::string command =
      "'" BATTEN_CLI "' fair '" + kExamples + "04-fairing/swan.csv' --quiet --out '" +
      (ran.out / "auto.csv").string() + "' --report '" + (ran.out / "auto.json").string() + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  const auto alone = nlohmann::json::parse(std::ifstream(ran.out / "auto.json"))["curves"][0];
  CHECK(after["bending"].get<double>() < 0.98 * alone["after"]["bending"].get<double>());
  // Far from the brushes nothing has changed: the head.
  const auto one = batten::read_point_lines(ran.out / "auto.csv")[0].points;
  const auto two = batten::read_point_lines(ran.out / "swan-fair.csv")[0].points;
  REQUIRE(one.size() == two.size());
  int head = 0;
  for (size_t i = 0; i < one.size(); ++i)
    if (one[i].z() > 140) {
      ++head;
      CHECK((one[i] - two[i]).norm() < 1e-9);
    }
  CHECK(head > 50);
}

TEST_CASE("published hulls are skinned and compared with the surfaces in their files") {
  if (!BATTEN_TEST_CGAL) {
    WARN("skipped: these regions need the Delaunay mesher, and this build has no CGAL");
    return;
  }
  for (const std::string file : {"lines-ship-iges/wigley.iges", "lines-ship-iges/series_60.iges",
                                 "lines-dealii-iges/DTMB-5415_bulbous_bow.iges"}) {
    const fs::path path = batten_test::optional_data(file);
    if (path.empty()) {
      WARN("skipped: " << file << " is not there (set BATTEN_TEST_DATA)");
      continue;
    }
    INFO(file);
    const fs::path out = batten_test::scratch("hull");
    const std::string command = "'" BATTEN_CLI "' skin '" + path.string() +
                                "' --unit m --quiet --out '" + out.string() + "' --compare '" +
                                path.string() + "'";
    REQUIRE(std::system((command + " 2> /dev/null").c_str()) == 0);
    const auto report = nlohmann::json::parse(std::ifstream(out / "report.json"));
    CHECK(report["surface"]["max_line_residual"].get<double>() <= 1e-10);
    // Metres stay metres, and the surface is the hull's, not another one.
    CHECK(report["surface"]["size"].get<double>() < 150);
    CHECK(report["comparison"]["rms_relative"].get<double>() < 0.04);
    CHECK(report["comparison"]["rms_relative"].get<double>() > 1e-4);
  }
}
