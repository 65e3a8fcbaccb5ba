// SPDX-License-Identifier: MPL-2.0
// Fairing of curves: the command and the scenes.
#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/lines/curve_files.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;
using batten::read_point_lines;
using batten::Vec3;
using Catch::Matchers::Contains;

namespace {

/// Jitter of a hand drawing: the same for the same number.
double jitter(int i) {
  const double x = std::sin(12.9898 * i + 78.233) * 43758.5453;
  return 2 * (x - std::floor(x)) - 1;
}

std::string row(double x, double y, double z) {
  return batten::format_number(x) + "," + batten::format_number(y) + "," +
         batten::format_number(z) + "\n";
}

/// A wave of 200 mm with 101 points, drawn with `noise` mm.
std::string wave(double noise, int seed = 0, double z = 0) {
  std::string text;
  for (int i = 0; i <= 100; ++i)
    text += row(2.0 * i + noise * jitter(seed + 3 * i),
                30 * std::sin(0.04 * i) + noise * jitter(seed + 3 * i + 1),
                z + noise * jitter(seed + 3 * i + 2));
  return text;
}

/// A closed curve, its last point equal to its first.
std::string ring(double noise) {
  std::string text;
  for (int i = 0; i <= 120; ++i) {
    const double a = 2 * M_PI * (i % 120) / 120;
    text += row((60 + noise * jitter(i % 120)) * std::cos(a),
                (40 + noise * jitter(500 + i % 120)) * std::sin(a), 5);
  }
  return text;
}

nlohmann::json json(const CliCase& c, const std::string& name) {
  return nlohmann::json::parse(contents(c / name));
}

double distance(const std::vector<Vec3>& points, const Vec3& p) {
  double least = 1e300;
  for (const Vec3& q : points) least = std::min(least, (q - p).norm());
  return least;
}

}  // namespace

TEST_CASE("a drawn file becomes a fair one of any kind, with as many points", "[apps][fair]") {
  const CliCase c("fair_kinds");
  c.file("two.csv", "x,y,z\n" + wave(0.5) + "\n" + ring(0.5));
  for (const std::string ending : {".curves", ".csv", ".obj", ".vtp", ".dxf", ".step", ".iges"}) {
    const CliResult r = c.run({"fair", "two.csv", "--out", "fair" + ending, "--report", "r.json"});
    INFO(ending << "\n" << r.err);
    REQUIRE(r.code == 0);
    CHECK(r.err.empty());
    CHECK_THAT(r.out, Contains("two_1") && Contains("two_2") && Contains("2 curves"));
    CHECK(fs::file_size(c / ("fair" + ending)) > 1000);
    const auto curves = json(c, "r.json")["faired_curves"];
    REQUIRE(curves.size() == 2);
    for (const auto& curve : curves) {
      INFO(curve.dump(1));
      CHECK(curve["faired"].get<bool>());
      CHECK(curve["after"]["extrema"].get<int>() < curve["before"]["extrema"].get<int>() / 2);
      CHECK(curve["after"]["bending"].get<double>() < curve["before"]["bending"].get<double>() / 3);
      CHECK(curve["deviation"]["max"].get<double>() < 1.5);
      CHECK(curve["deviation"]["rms"].get<double>() > 0.1);
      CHECK(curve["wavelength"].get<double>() > 5);
    }
    CHECK_FALSE(curves[0]["closed"].get<bool>());
    CHECK(curves[1]["closed"].get<bool>());
    CHECK(curves[0]["points"].get<int>() == 101);
  }
  for (const std::string ending : {".curves", ".csv", ".obj"}) {
    const auto before = read_point_lines(c / "two.csv"),
               after = read_point_lines(c / ("fair" + ending));
    REQUIRE(after.size() == 2);
    for (size_t i = 0; i < 2; ++i) {
      REQUIRE(after[i].points.size() == before[i].points.size());
      for (size_t k = 0; k < after[i].points.size(); ++k)
        CHECK((after[i].points[k] - before[i].points[k]).norm() < 1.5);
    }
    CHECK((after[1].points.front() - after[1].points.back()).norm() < 1e-7);
  }
  CHECK(c.run({"fair", "two.csv", "--out", "again.csv", "--quiet"}).out.empty());
}

TEST_CASE("a fair curve follows its options", "[apps][fair]") {
  const CliCase c("fair_options");
  c.file("w.csv", wave(0.5));
  const auto given = read_point_lines(c / "w.csv")[0].points;
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"fair", "w.csv", "--out", "o.csv", "--report", "r.json"};
    words.insert(words.end(), more.begin(), more.end());
    const CliResult r = c.run(words);
    INFO(r.err);
    REQUIRE(r.code == 0);
    return json(c, "r.json")["faired_curves"][0];
  };
  for (const double limit : {0.6, 1.0, 3.0}) {
    const auto curve = run({"--deviation", batten::format_number(limit)});
    CHECK(curve["deviation"]["max"].get<double>() <= limit * 1.01);
    CHECK(curve["deviation"]["max"].get<double>() > 0.5 * limit);
  }
  const auto fine = run({"--wavelength", "8"}), coarse = run({"--wavelength", "80"});
  CHECK(fine["wavelength"].get<double>() == 8);
  CHECK(coarse["after"]["extrema"].get<int>() < fine["after"]["extrema"].get<int>());
  CHECK(coarse["deviation"]["rms"].get<double>() > fine["deviation"]["rms"].get<double>());
  // Free ends move, fixed ends do not.
  run({"--wavelength", "40"});
  CHECK((read_point_lines(c / "o.csv")[0].points.front() - given.front()).norm() > 1e-3);
  run({"--wavelength", "40", "--fix-ends"});
  CHECK((read_point_lines(c / "o.csv")[0].points.front() - given.front()).norm() < 1e-9);
  CHECK((read_point_lines(c / "o.csv")[0].points.back() - given.back()).norm() < 1e-9);
  CHECK(run({"--closed"})["closed"].get<bool>());
  // Few segments, within the requested distance of the fair curve.
  const auto all = run({"--wavelength", "40"});
  const auto fair = read_point_lines(c / "o.csv")[0].points;
  const auto few = run({"--wavelength", "40", "--segments", "0.05"});
  CHECK(few["segments"].get<int>() * 4 < all["segments"].get<int>());
  const auto reduced = read_point_lines(c / "o.csv")[0].points;
  REQUIRE(reduced.size() == fair.size());
  double worst = 0;
  for (size_t i = 0; i < fair.size(); ++i) worst = std::max(worst, (fair[i] - reduced[i]).norm());
  CHECK(worst < 0.2);  // along the curve they may move slightly more than across it
  CHECK(worst > 1e-6);
}

TEST_CASE("a drawn curve stays within any given deviation, also far below its noise",
          "[apps][fair]") {
  const CliCase c("fair_deviation");
  const std::string swan = BATTEN_SOURCE_DIR "/examples/04-fairing/swan.csv";
  for (const double limit : {0.02, 0.5, 1.0, 2.5}) {
    CAPTURE(limit);
    const CliResult r = c.run({"fair", swan, "--deviation", batten::format_number(limit), "--out",
                               "o.csv", "--report", "r.json"});
    CHECK(r.code == 0);
    const auto curve = json(c, "r.json")["faired_curves"][0];
    CHECK(curve["deviation"]["max"].get<double>() <= limit);
    CHECK(curve["after"]["length"].get<double>() < 1.2 * curve["before"]["length"].get<double>());
  }
}

TEST_CASE("strokes without length are named and passed through, the sketch is faired",
          "[apps][fair]") {
  const CliCase c("fair_dots");
  c.file("s.curves",
         "v 4\n0 0 0\n10 1 0\n20 -1 0\n30 0 0\nv 1\n1 2 3\nv 3\n4 5 6\n4 5 6\n4 5 6\n"
         "v 5\n0 0 9\n0 0 9\n10 2 9\n20 -2 9\n30 0 9\n");
  const CliResult r = c.run({"fair", "s.curves", "--out", "o.curves", "--report", "r.json"});
  CHECK(r.code == 0);
  CHECK_THAT(r.err, Contains("warning: curve 's_2' has only one point") &&
                        Contains("warning: curve 's_3' has zero length"));
  const auto lines = read_point_lines(c / "o.curves");
  REQUIRE(lines.size() == 4);
  CHECK(lines[1].points == std::vector<Vec3>{{1, 2, 3}});
  CHECK(lines[2].points == std::vector<Vec3>(3, Vec3(4, 5, 6)));
  CHECK(lines[3].points.size() == 4);  // the first two coincide
  CHECK_FALSE(json(c, "r.json")["faired_curves"][1]["faired"].get<bool>());
  const CliResult text = c.run({"fair", "s.curves", "--out", "o.csv"});
  CHECK(text.code == 0);
  CHECK_THAT(text.err, Contains("o.csv: 's_2' is not written"));
  const CliResult cad = c.run({"fair", "s.curves", "--out", "o.step"});
  CHECK(cad.code == 0);
  CHECK_THAT(cad.err, Contains("'s_2' is not written") && Contains("'s_3' is not written"));
  CHECK(batten::read_cad_lines(c / "o.step", 1e-3).size() == 2);
  c.file("t.curves", "v 2\n0 0 0\n1 0 0\nv 4\n0 0 0\n9 1 0\n9 9 0\n0 9 1\n");
  const CliResult loops = c.run({"fair", "t.curves", "--out", "t.obj", "--closed"});
  CHECK(loops.code == 0);
  CHECK_THAT(loops.err, Contains("'t_1' has too few points for a closed curve"));
  CHECK(read_point_lines(c / "t.obj").size() == 2);
  CHECK_THAT(c.run({"info", "s.curves"}).out, Contains("zero length  at (1, 2, 3)"));
}

TEST_CASE("curves of CAD files are faired by their shape and keep their names", "[apps][fair]") {
  const CliCase c("fair_cad");
  // A wave, and three sides of a rectangle with sharp corners.
  std::string rows = "o wave\nv 0 0 0\nv 30 12 4\nv 60 0 0\nv 90 -12 -4\nv 120 0 0\n";
  for (int i = 0; i <= 30; ++i)
    rows += "v " + std::to_string(10 * std::clamp(i < 20 ? i : 30 - i, 0, 10)) + " " +
            std::to_string(10 * std::clamp(i - 10, 0, 10)) + " 50\n";
  rows += "l 1 2 3 4 5\no frame\nl";
  for (int i = 0; i <= 30; ++i) rows += " " + std::to_string(6 + i);
  c.file("a.obj", rows + "\n");
  REQUIRE(c.run({"fair", "a.obj", "--out", "a.step", "--corner-angle", "40"}).code == 0);
  const auto names = [&](const std::string& file) {
    std::string all;
    for (const auto& line : batten::read_cad_lines(c / file, 1e-3)) all += line.name + " ";
    return all;
  };
  CHECK(names("a.step") == "wave frame.1 frame.2 frame.3 ");
  for (const std::string ending : {".step", ".igs"}) {
    const CliResult r = c.run(
        {"fair", "a.step", "--out", "b" + ending, "--report", "r.json", "--deviation", "0.05"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(names("b" + ending) == "wave frame.1 frame.2 frame.3 ");
    const auto curves = json(c, "r.json")["faired_curves"];
    for (const auto& curve : curves) {
      CHECK(curve["points"].get<int>() > (curve["name"] == "wave" ? 190 : 20));
      CHECK(curve["deviation"]["max"].get<double>() < 0.051);
    }
  }
  CHECK_THAT(c.run({"fair", "a.step", "--out", "c.step", "--only", "frame.4"}).err,
             Contains("'frame.4'") && Contains("did you mean 'frame.1'?"));
  CHECK(c.run({"fair", "a.step", "--out", "c.step", "--only", "wave", "--only", "frame.2"}).code ==
        0);
  CHECK(names("c.step") == "wave frame.2 ");
}

TEST_CASE("curves that cannot be faired are refused with their position, and nothing is written",
          "[apps][fair]") {
  const CliCase c("fair_mistakes");
  c.file("w.csv", wave(0.5));
  c.file("nan.csv", "0,0,0\n1,nan,0\n2,0,0\n");
  const auto fails = [&](std::vector<std::string> words, const std::string& part) {
    words.insert(words.begin(), "fair");
    const CliResult r = c.run(words);
    INFO(r.err);
    CHECK(r.code == 1);
    CHECK_THAT(r.err + r.out, Contains(part));
    CHECK_FALSE(fs::exists(c / "o.csv"));
  };
  fails({"none.csv", "--out", "o.csv"}, "none.csv");
  fails({"nan.csv", "--out", "o.csv"}, "nan.csv:2:3: found 'nan'");
  fails({"w.csv", "--out", "o.stepp"}, "did you mean '.step'");
  fails({"w.csv", "--out", "none/o.csv"}, "none/o.csv");
  fails({"w.csv", "--out", "o.csv", "--deviation", "0"}, "--deviation");
  fails({"w.csv", "--out", "o.csv", "--deviation", "1", "--wavelength", "1"}, "--wavelength");
  fails({"w.csv", "--out", "o.csv", "--closed", "--open"}, "--open");
  fails({"w.csv", "--out", "o.csv", "--only", "v"}, "'v'");
  fails({"w.csv"}, "--out");
  // Without a display, only the check of the picture fails.
  const CliResult r = c.run({"fair", "w.csv", "--out", "o.csv", "--picture", "p.png"});
  CHECK(r.code == 4);
  CHECK_THAT(r.err, Contains("p.png is not drawn") && Contains("display"));
  CHECK(fs::exists(c / "o.csv"));
  CHECK_FALSE(fs::exists(c / "p.png"));
}

TEST_CASE("fairing gives the same bits on one thread and on two", "[apps][fair]") {
  const CliCase c("fair_threads");
  std::string text;
  for (int i = 0; i < 30; ++i) text += wave(0.5, 1000 * i, 10 * i) + "\n";
  c.file("w.csv", text);
  REQUIRE(c.run({"fair", "w.csv", "--out", "a.csv", "--threads", "1"}).code == 0);
  const CliResult r = c.run({"fair", "w.csv", "--out", "b.csv", "--threads", "2"});
  CHECK(r.code == 0);
  CHECK(contents(c / "a.csv") == contents(c / "b.csv"));
  CHECK_THAT(r.out, Contains("... 10 more") && Contains("30 curves"));
}

namespace {

const std::string kFairedScene = R"(unit = "mm"
[[curve]]
name = "wave"
file = "w.csv"
[[curve]]
name = "rail"
points = [[0,0,40],[50,2,40],[100,-2,40],[150,1,40],[200,0,40]]
)";

}  // namespace

TEST_CASE("stages of a scene follow each other, local ones leave the rest alone", "[apps][fair]") {
  const CliCase c("fair_scene");
  c.file("w.csv", wave(0.5));
  const std::string fair = "[[fair]]\nname = \"all\"\ncurves = \"wave\"\nwavelength = 25\n";
  const std::string out = "[output]\ncsv = \"o.csv\"\nvtp = \"o.vtp\"\nstep = \"o.stp\"\n";
  c.file("a.toml", kFairedScene + fair + out);
  c.file("b.toml", kFairedScene + fair +
                       "[[fair]]\nname = \"spot\"\nwavelength = 60\n"
                       "brush = { at = [100, 22.7, 0], radius = 30 }\n" +
                       out);
  const CliResult a = c.run({"run", "a.toml", "--out", "a"}),
                  b = c.run({"run", "b.toml", "--out", "b"});
  INFO(a.err << b.err);
  REQUIRE(a.code == 0);
  REQUIRE(b.code == 0);
  CHECK_THAT(a.out, Contains("wave") && Contains("o.stp") && Contains("report.json"));
  const auto one = read_point_lines(c / "a/o.csv")[0].points;
  const auto two = read_point_lines(c / "b/o.csv")[0].points;
  int same = 0, other = 0;
  for (size_t i = 0; i < one.size(); ++i) {
    const bool outside = (one[i] - Vec3(100, 22.7, 0)).norm() > 35;
    const double moved = (one[i] - two[i]).norm();
    if (outside) CHECK(moved < 1e-9);
    same += outside;
    other += !outside && moved > 1e-3;
  }
  CHECK(same > 50);
  CHECK(other > 5);
  // No stage applies to the rail: it is unchanged.
  const auto rail = report(c, "a")["faired_curves"][1];
  CHECK(rail["name"] == "rail");
  CHECK_FALSE(rail["faired"].get<bool>());
  CHECK(rail["deviation"]["max"].get<double>() < 1e-12);
  CHECK(c.run({"run", "a.toml", "--out", "s", "--set", "all.wavelength=50"}).code == 0);
  CHECK(report(c, "s")["faired_curves"][0]["wavelength"].get<double>() == 50);
  CHECK(report(c, "s")["parameters"][0]["name"] == "all.wavelength");
  CHECK_THAT(c.run({"info", "b.toml"}).out, Contains("all.wavelength = 25") &&
                                                Contains("spot.wavelength = 60") &&
                                                Contains("rail"));
}

TEST_CASE("conditions of a scene hold, contradictions are named", "[apps][fair]") {
  const CliCase c("fair_conditions");
  c.file("w.csv", wave(0.5));
  const std::string fair = kFairedScene + "[[fair]]\ncurves = [\"wa*\"]\nwavelength = 30\n";
  const std::string flat =
      "[[fair.condition]]\nname = \"flat\"\ntype = \"plane\"\nat = [0,0,0]\ndirection = [0,0,1]\n";
  c.file("s.toml", fair + flat +
                       "[[fair.condition]]\nname = \"post\"\ntype = \"point\"\nat = [100, 25, 0]\n"
                       "[output]\ncsv = \"o.csv\"\n");
  const CliResult r = c.run({"run", "s.toml", "--out", "o"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto curve = report(c, "o")["faired_curves"][0];
  CHECK(curve["max_residual"].get<double>() <= 1e-12);
  for (const Vec3& p : read_point_lines(c / "o/o.csv")[0].points) CHECK(std::abs(p.z()) < 1e-9);
  c.fails(
      fair + flat + "[[fair.condition]]\nname = \"post\"\ntype = \"point\"\nat = [100, 25, 7]\n", 2,
      {"flat", "post"});
}

TEST_CASE("errors in fairing scenes are reported with their position", "[apps][fair]") {
  const CliCase c("fair_scene_mistakes");
  c.file("w.csv", wave(0.5));
  const auto fails = [&](const std::string& more, const std::vector<std::string>& parts) {
    c.fails(kFairedScene + more, 1, parts);
  };
  const std::string fair = "[[fair]]\n";
  fails(fair + "wavelenght = 3\n", {"s.toml:9:1:", "'wavelenght'", "did you mean 'wavelength'?"});
  fails(fair + "wavelength = 0\n", {"s.toml:9:14:", "above 0"});
  fails(fair + "wavelength = 1\ndeviation = 1\n", {"s.toml:9:14:", "both 'deviation'"});
  fails(fair + "curves = \"wabe\"\n", {"s.toml:9:10:", "'wabe'", "did you mean 'wave'?"});
  fails(fair + "brush = { at = [0,0,0], radius = 3 }\n", {"s.toml:8:1:", "no 'wavelength'"});
  fails(fair + "brush = { at = [0,0,0], radius = 3 }\nwavelength = 3\nalpha = 1\n",
        {"s.toml:11:9:", "'alpha' beside 'brush'"});
  fails(fair + "brush = { at = [0,0,900], radius = 3 }\nwavelength = 3\n",
        {"s.toml:8:1:", "'fair-1'", "a brush that meets none"});
  fails(fair + "alpha = -1\n", {"s.toml:9:9:", "0 or more"});
  fails(fair + "corner_angle = 190\n", {"s.toml:9:16:", "180"});
  fails(fair + "[[fair.condition]]\nname = \"x\"\ntype = \"pt\"\n",
        {"s.toml:11:8:", "point, tangent, end_curvature, plane, symmetry"});
  fails(fair + "[[fair.condition]]\nname = \"x\"\ntype = \"point\"\n", {"s.toml:9:1:", "no 'at'"});
  fails(fair + "[[fair.condition]]\nname = \"x\"\ntype = \"end_curvature\"\nat = [0,0,0]\n",
        {"s.toml:12:6:", "expected none"});
  fails(fair + "name = \"a\"\n" + fair + "name = \"a\"\n", {"s.toml:11:8:", "first in line 9"});
  fails(fair + "[output]\nstep = \"a.csv\"\n", {"s.toml:10:8:", ".step"});
  fails(fair + "[[picture]]\nfile = \"a.png\"\nshow = \"comb\"\n",
        {"s.toml:11:8:", "did you mean 'combs'?"});
  fails(fair + "[[load]]\nname = \"x\"\n", {"s.toml:9:3:", "'load'"});
  c.fails(kFairedScene + fair + "name = \"a\"\nwavelength = 3\n", 1,
          {"'a.wavelenght'", "did you mean 'a.wavelength'?"}, {"--set", "a.wavelenght=4"});
  c.fails(kFairedScene + fair + "name = \"a\"\nwavelength = 3\n", 1, {"--set", "above 0"},
          {"--set", "a.wavelength=-4"});
  c.fails("unit = \"mm\"\n[[fair]]\n", 1, {"no curves"});
}

TEST_CASE("curves are faired before a surface is made of them", "[apps][fair]") {
  const CliCase c("fair_skin");
  // A rectangle of four noisy curves with common ends.
  std::string lines = "unit = \"mm\"\n";
  const Vec3 corners[4] = {{0, 0, 0}, {200, 0, 0}, {200, 120, 0}, {0, 120, 0}};
  for (int k = 0; k < 4; ++k) {
    std::string text;
    for (int i = 0; i <= 40; ++i) {
      const double noise = i == 0 || i == 40 ? 0 : 0.4, t = i / 40.0;
      const Vec3 p = (1 - t) * corners[k] + t * corners[(k + 1) % 4];
      text +=
          row(p.x() + noise * jitter(300 * k + 3 * i), p.y() + noise * jitter(300 * k + 3 * i + 1),
              10 * std::sin(M_PI * t) + noise * jitter(300 * k + 3 * i + 2));
    }
    const std::string name = "side" + std::to_string(k);
    c.file(name + ".csv", text);
    lines += "[[curve]]\nname = \"" + name + "\"\nfile = \"" + name + ".csv\"\n";
  }
  const std::string skin =
      "[mesh]\nmesher = \"fan\"\nedge_length = 20\n[output]\nstep = \"s.step\"\n";
  const std::string fair = "[[fair]]\nname = \"sides\"\nwavelength = 80\ncorner_angle = 180\n";
  c.file("fair.toml", lines + fair + skin);
  const CliResult r = c.run({"run", "fair.toml", "--out", "fair"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto done = report(c, "fair");
  CHECK(done["faired_curves"].size() == 4);
  for (const auto& curve : done["faired_curves"]) {
    CHECK(curve["deviation"]["max"].get<double>() < 1.5);
    CHECK(curve["after"]["extrema"].get<int>() < curve["before"]["extrema"].get<int>());
  }
  CHECK(done["surface"]["max_curve_residual"].get<double>() <= 1e-10);
  // The corners are at their original positions.
  std::vector<Vec3> ends;
  for (const auto& line : batten::read_cad_lines(c / "fair/s.step", 1e-3))
    ends.push_back(line.curve->evaluate(line.curve->start()));
  for (const Vec3& corner : corners) CHECK(distance(ends, corner) < 1e-7);
  CHECK(c.run({"run", "fair.toml", "--out", "more", "--set", "sides.wavelength=200"}).code == 0);
  CHECK(report(c, "more")["faired_curves"][0]["wavelength"].get<double>() == 200);
  c.file("sweep.toml", lines + fair + skin +
                           "[[sweep]]\nfile = \"s.png\"\nparameter = \"sides.wavelength\"\n"
                           "values = [1, 2]\n");
  const CliResult sweep = c.run({"run", "sweep.toml", "--out", "sweep"});
  CHECK(sweep.code == 1);
  CHECK_THAT(sweep.err, Contains("changes the curves"));
}
