// SPDX-License-Identifier: MPL-2.0
// fair = "variation": a half cylinder from two arcs and two straight curves.
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

std::string line_through(const std::string& name, const std::string& points) {
  return "[[curve]]\nname = \"" + name + "\"\npoints = [" + points + "]\n";
}

/// A half circle of radius 50 in the plane of this y.
std::string arc(const std::string& name, double y, bool reversed) {
  constexpr int pieces = 40;
  std::string points;
  for (int i = 0; i <= pieces; ++i) {
    const double a = std::numbers::pi * (reversed ? pieces - i : i) / pieces;
    points += "[" + std::to_string(50 * std::cos(a)) + ", " + std::to_string(y) + ", " +
              std::to_string(50 * std::sin(a)) + "],";
  }
  return line_through(name, points);
}

std::string half_cylinder(const std::string& skin, const std::string& mesh = "") {
  return "unit = \"mm\"\nname = \"half cylinder\"\n" + arc("front", 0, false) +
         line_through("left", "[-50,0,0], [-50,120,0]") + arc("back", 120, true) +
         line_through("right", "[50,120,0], [50,0,0]") + "[mesh]\nedge_length = 10\n" + mesh +
         "[skin]\n" + skin;
}

}  // namespace

TEST_CASE("a half cylinder is recovered from its four curves", "[apps][fair]") {
  const CliCase c("fair_surface");
  const double area = std::numbers::pi * 50 * 120;
  c.file("s.toml", half_cylinder("fair = \"bending\"\n"));
  REQUIRE(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  CHECK(report(c, "out")["surface"]["area"].get<double>() < 0.95 * area);
  // Without options, the intended cylinder is recognised.
  c.file("s.toml", half_cylinder(""));
  REQUIRE(c.run({"run", "s.toml", "--out", "out"}).code == 0);
  CHECK(report(c, "out")["surface"]["area"].get<double>() == Approx(area).epsilon(1e-3));
  CHECK_FALSE(report(c, "out")["surface"].contains("fairing"));
  fs::remove_all(c / "out");

  c.file("s.toml", half_cylinder("fair = \"variation\"\n"));
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(r.out.find("faired") != std::string::npos);
  const auto surface = batten_test::report(c, "out")["surface"];
  CHECK(surface["area"].get<double>() == Approx(area).epsilon(0.003));
  CHECK(surface["fairing"]["converged"] == true);
  CHECK(surface["fairing"]["functional"] < surface["fairing"]["start_functional"]);
  CHECK(surface["fairing"]["max_displacement"].get<double>() > 0);
  CHECK(surface["max_curve_residual"].get<double>() < 1e-10);
}

TEST_CASE("settings that a fair shape excludes are refused with their position", "[apps][fair]") {
  const CliCase c("fair_refused");
  const std::string fair = "fair = \"variation\"\n";
  c.fails(half_cylinder(fair + "boundary = \"corners\"\n"), 1,
          {"s.toml:", "boundary = \"curves\""});
  c.fails(half_cylinder(fair, "element = \"z12\"\n"), 1, {"s.toml:", "element = \"hct\""});
  c.fails(half_cylinder("fair = \"variaton\"\n"), 1, {"did you mean 'variation'"});
  c.fails(half_cylinder("") + "\n[[join]]\ncurves = [\"front\"]\ncontinuity = \"G2\"\n", 1,
          {"s.toml:", "\"G2\" for a surface that is not faired", "variation"});
}

TEST_CASE("loads bend a fair shape, and a live session comes back to it", "[apps][fair]") {
  const CliCase c("fair_loaded");
  const double area = std::numbers::pi * 50 * 120;
  const std::string acts =
      "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = 0\nmin = -200\nmax = 200\n"
      "[[constraint]]\nname = \"crown\"\ntype = \"point\"\nat = [0, 60, 50]\n"
      "to = [0, 60, 50]\nrange = 20\n";
  for (const std::string fair : {"variation", "loft"}) {
    INFO(fair);
    c.file("s.toml", half_cylinder("fair = \"" + fair + "\"\n" +
                                   (fair == "loft" ? "sections = [\"front\"]\n" : "")) +
                         acts);
    const CliResult run = c.run({"run", "s.toml", "--out", "run"});
    INFO(run.err);
    REQUIRE(run.code == 0);
    const auto still = nlohmann::json::parse(contents(c / "run/report.json"))["surface"];
    CHECK(still["area"].get<double>() == Approx(area).epsilon(0.003));
    CHECK(still["bending_energy"].get<double>() < 1e-3);
    const CliResult live = c.run({"sculpt", "s.toml", "--out", "out", "--sweep", "crown.z=50:56:3",
                                  "--sweep", "swell=100:0:2"});
    INFO(live.err);
    REQUIRE(live.code == 4);  // the two contact sheets, without a display
    const auto sweeps = batten_test::report(c, "out")["sculpting"]["sweeps"];
    // Back at the start, the surface equals that of `run`.
    CHECK(report(c, "out")["surface"]["area"].get<double>() ==
          Approx(still["area"].get<double>()).epsilon(1e-6));
    CHECK(sweeps[0]["rows"][2]["area"].get<double>() > area);
    CHECK(sweeps[0]["rows"][2]["residual"].get<double>() < 1e-10);
    CHECK(std::abs(sweeps[1]["rows"][0]["area"].get<double>() - area) >
          1);  // in either direction of normals
    fs::remove_all(c / "run");
    fs::remove_all(c / "out");
  }
}

TEST_CASE("a loft runs straight between sections, and names curves that are no section",
          "[apps][fair]") {
  const CliCase c("loft");
  const double area = std::numbers::pi * 50 * 120;
  c.file("s.toml", half_cylinder("fair = \"loft\"\nsections = [\"back\"]\n"));
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(r.out.find("lofted") != std::string::npos);
  const auto surface = batten_test::report(c, "out")["surface"];
  CHECK(surface["fair"] == "loft");
  CHECK(surface["area"].get<double>() == Approx(area).epsilon(0.002));
  CHECK(surface["max_curve_residual"].get<double>() < 1e-10);

  c.file("s.toml", half_cylinder("fair = \"loft\"\nsections = [\"bakc\"]\n"));
  const CliResult wrong = c.run({"run", "s.toml", "--out", "wrong"});
  CHECK(wrong.code == 1);
  CHECK(wrong.err.find("s.toml:") != std::string::npos);
  CHECK(wrong.err.find("'bakc' is neither a side") != std::string::npos);
  c.file("s.toml", half_cylinder("fair_strength = 0.5\n"));
  CHECK(c.run({"run", "s.toml", "--out", "wrong"}).err.find("only with fair = \"variation\"") !=
        std::string::npos);
  c.file("s.toml", half_cylinder("sections = [\"back\"]\n"));
  CHECK(c.run({"run", "s.toml", "--out", "wrong"}).err.find("only with fair = \"loft\"") !=
        std::string::npos);
}

TEST_CASE("a self-intersecting surface of one face is reported", "[apps][fair]") {
  // A strip between two loops like the letter alpha; each of them rises and so does not intersect
  // itself.
  const CliCase c("alpha_strip");
  const auto loop = [](const std::string& name, double y, bool reversed) {
    constexpr int pieces = 40;
    std::string points;
    for (int i = 0; i <= pieces; ++i) {
      const double t = 3.0 * (reversed ? pieces - i : i) / pieces - 1.5;
      points += "[" + std::to_string(50 * (t * t - 1)) + ", " + std::to_string(y + 5 * t) + ", " +
                std::to_string(50 * t * (t * t - 1)) + "],";
    }
    return line_through(name, points);
  };
  const auto side = [](const std::string& name, double t, bool reversed) {
    const std::string end = ", " + std::to_string(50 * t * (t * t - 1)) + "]",
                      start = "[" + std::to_string(50 * (t * t - 1)) + ", ";
    const std::string near = start + std::to_string(5 * t) + end,
                      far = start + std::to_string(40 + 5 * t) + end;
    return line_through(name, reversed ? far + "," + near : near + "," + far);
  };
  c.file("s.toml", "unit = \"mm\"\nname = \"alpha\"\n" + loop("front", 0, false) +
                       side("right", 1.5, false) + loop("back", 40, true) +
                       side("left", -1.5, true) + "[mesh]\nedge_length = 8\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  CHECK(r.code == 4);
  CHECK(r.out.find("intersects itself") != std::string::npos);
  const auto defects = batten_test::report(c, "out")["defects"];
  REQUIRE(defects.size() == 1);
  CHECK(defects[0]["kind"] == "self-intersection");
}

TEST_CASE("sections alone make a surface: their rails are found", "[apps][fair]") {
  const CliCase c("only_sections");
  const auto arch = [](const std::string& name, double y, double height, bool reversed) {
    constexpr int pieces = 20;
    std::string points;
    for (int i = 0; i <= pieces; ++i) {
      const double x = 2.0 * (reversed ? pieces - i : i) / pieces - 1;
      points += "[" + std::to_string(50 * x) + ", " + std::to_string(y) + ", " +
                std::to_string(height * (1 - x * x)) + "],";
    }
    return line_through(name, points);
  };
  const std::string sections =
      arch("b", 60, 30, true) + arch("a", 0, 20, false) + arch("c", 130, 25, false);
  const auto scene = [&](const std::string& order) {
    return "unit = \"mm\"\nname = \"arches\"\n" + sections + "[skin]\nfair = \"loft\"\n" +
           "sections = " + order + "\n";
  };
  c.file("s.toml", scene("[\"a\", \"b\", \"c\"]"));
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto report = batten_test::report(c, "out");
  CHECK(report["curves"]["count"] == 5);
  CHECK(report["surface"]["max_curve_residual"].get<double>() < 1e-10);
  CHECK(report["defects"].empty());
  // Between the areas of the flat floor and of the highest arch along the whole length.
  CHECK(report["surface"]["area"].get<double>() > 13000);
  CHECK(report["surface"]["area"].get<double>() < 17000);
  const auto error = [&](const std::string& order) {
    c.file("s.toml", scene(order));
    const CliResult wrong = c.run({"run", "s.toml", "--out", "wrong"});
    CHECK(wrong.code == 1);
    return wrong.err;
  };
  CHECK(error("[\"a\", \"b\"]").find("2 of 3 curves are sections") != std::string::npos);
  CHECK(error("[\"b\", \"b\", \"a\"]").find("so that rails can connect them") != std::string::npos);
  CHECK(error("[\"a\", \"b\", \"d\"]").find("s.toml:") != std::string::npos);
}
