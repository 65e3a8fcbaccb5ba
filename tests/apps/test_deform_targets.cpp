// SPDX-License-Identifier: MPL-2.0
// batten deform with [[target]]: a mesh follows a scan, another mesh, CAD faces.
#include <cmath>
#include <numbers>
#include <random>

#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

const std::string kPlate = BATTEN_SOURCE_DIR "/examples/10-plate-with-holes/plate.obj";

double styled(double x, double y) {
  return 8 * std::sin(x / 90 + 0.3) * std::cos(y / 110) + 0.05 * x;
}

/// A scan of a surface z(x, y) around the plate of 300 × 300, with other triangles and noise.
std::string scan(double noise) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal(0, noise);
  constexpr int n = 120;
  std::string text;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = -20 + 340.0 * i / n, y = -20 + 340.0 * (j + 0.4 * (i % 2)) / n;
      text += "v " + std::to_string(x) + " " + std::to_string(y) + " " +
              std::to_string(styled(x, y) + (noise > 0 ? normal(generator) : 0)) + "\n";
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j + 1;
      for (const auto& [b, c] : {std::pair{a + n + 1, a + n + 2}, {a + n + 2, a + 1}})
        text += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    }
  return text;
}

std::string scene(const std::string& target) {
  return "unit = \"mm\"\nmesh = \"" + kPlate + "\"\n[[features]]\nof = \"hole-*\"\n[[target]]\n" +
         target;
}

}  // namespace

TEST_CASE("a plate follows a noisy scan, and its holes stay round", "[apps][deform]") {
  const CliCase c("deform_scan");
  c.file("scan.obj", scan(0.2));
  c.file("s.toml", scene("file = \"scan.obj\"\n"));
  const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out"), target = j["targets"][0];
  CHECK(target["ignored"] == 0);
  CHECK(target["rms"].get<double>() < 1.2 * 0.2);
  CHECK(target["back_rms"].get<double>() < 1.2 * 0.2);
  for (const auto& f : j["features"]) CHECK(f["max_rigid_error"].get<double>() < 1e-12);
  CHECK(j["quality"]["after"]["jacobian"]["worst"].get<double>() >
        0.9 * j["quality"]["before"]["jacobian"]["worst"].get<double>());
  // The noise is smoothed: the error of the free part is far below it.
  const batten::Points p = batten::MeshFile::read(c / "out/plate-deformed.obj").shells().points;
  double sum = 0;
  for (long v = 0; v < p.rows(); ++v) {
    const double off = p(v, 2) - styled(p(v, 0), p(v, 1));
    sum += off * off;
  }
  CHECK(std::sqrt(sum / static_cast<double>(p.rows())) < 0.25);
}

TEST_CASE("targets in other places and units are refused or scaled", "[apps][deform]") {
  const CliCase c("deform_target_input");
  c.file("scan.obj", scan(0));
  c.fails(scene("file = \"scan.obj\"\nunit = \"m\"\n"), 1, {"check its unit and position"}, {},
          "deform");
  c.fails(scene("file = \"none.obj\"\n"), 1, {"none.obj"}, {}, "deform");
  c.fails(scene("file = \"scan.obj\"\nof = \"hole-9\"\n"), 1, {"did you mean"}, {}, "deform");
  c.fails(scene("file = \"scan.obj\"\nreach = -1\n"), 1, {"reach"}, {}, "deform");
  c.file("s.toml", scene("file = \"scan.obj\"\noffset = 2\n"));
  REQUIRE(c.run({"deform", "s.toml", "--out", "two"}).code == 0);
  CHECK(report(c, "two")["targets"][0]["rms"].get<double>() < 0.3);
  const auto above = batten::MeshFile::read(c / "two/plate-deformed.obj").shells().points;
  CHECK(above(0, 2) - styled(above(0, 0), above(0, 1)) == Approx(2).margin(0.3));
}

TEST_CASE("handles and fixed vertices stay exact beside a target", "[apps][deform]") {
  const CliCase c("deform_target_handle");
  c.file("scan.obj", scan(0));
  c.file("s.toml", scene("file = \"scan.obj\"\n") +
                       "[[select]]\nname = \"left\"\nbox = [[0, 0, -1], [0, 300, 1]]\n"
                       "[[edit]]\nfixed = \"left\"\n");
  const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto before = batten::MeshFile::read(kPlate).shells().points,
             after = batten::MeshFile::read(c / "out/plate-deformed.obj").shells().points;
  for (long v = 0; v < before.rows(); ++v)
    if (before(v, 0) == 0) CHECK(after.row(v) == before.row(v));
  CHECK((after - before).col(2).cwiseAbs().maxCoeff() > 5);
}

TEST_CASE("a chain of the mesh follows the curve of a file", "[apps][deform]") {
  const CliCase c("deform_curve_file");
  std::string arc;
  for (int i = 60; i >= 0; --i) {  // against the direction of the chain, in metres
    const double x = 0.3 * i / 60;
    arc += std::to_string(x) + ", 0, " +
           std::to_string(0.02 * std::sin(std::numbers::pi * i / 60)) + "\n";
  }
  c.file("arc.csv", arc);
  const std::string head = "unit = \"mm\"\nmesh = \"" + kPlate +
                           "\"\n[[features]]\nof = \"hole-*\"\n"
                           "[[select]]\nname = \"back\"\nbox = [[0, 300, -1], [300, 300, 1]]\n"
                           "[[edit]]\nfixed = \"back\"\n"
                           "[[curve]]\nname = \"front\"\nthrough = [[0, 0, 0], [300, 0, 0]]\n";
  c.file("s.toml", head + "file = \"arc.csv\"\nunit = \"m\"\n");
  const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto before = batten::MeshFile::read(kPlate).shells().points,
             after = batten::MeshFile::read(c / "out/plate-deformed.obj").shells().points;
  int count = 0;
  for (long v = 0; v < before.rows(); ++v)
    if (before(v, 1) == 0) {
      ++count;
      CHECK(after(v, 2) ==
            Approx(20 * std::sin(std::numbers::pi * after(v, 0) / 300)).margin(0.01));
      CHECK(std::abs(after(v, 1)) < 1e-6);
      CHECK(after(v, 0) == Approx(before(v, 0)).margin(3));
    }
  CHECK(count > 20);

  const CliCase bad("deform_curve_file_refused");
  bad.file("arc.csv", arc);
  bad.file("two.csv", arc + "\n\n0, 0, 0\n0, 0.3, 0.1\n");
  bad.fails(head + "file = \"two.csv\"\n", 1, {"found 2 curves in two.csv", "one of:"}, {},
            "deform");
  bad.fails(head + "closed = true\nfile = \"arc.csv\"\nunit = \"m\"\n", 1,
            {"found an open curve for a closed chain"}, {}, "deform");
  bad.fails(head + "curve = \"arc\"\n", 1, {"without a file"}, {}, "deform");
}

TEST_CASE("a mesh follows the surface of a scene that its loads shape", "[apps][deform]") {
  const CliCase c("deform_scene_target");
  const auto surface = [](double swell) {
    std::string text = "unit = \"cm\"\n[mesh]\nedge_length = 3\n";
    const std::string corners[] = {"[-2, -2, 0]", "[32, -2, 0]", "[32, 32, 0]", "[-2, 32, 0]"};
    for (int k = 0; k < 4; ++k)
      text += "[[curve]]\nname = \"side " + std::to_string(k + 1) + "\"\npoints = [" + corners[k] +
              ", " + corners[(k + 1) % 4] + "]\n";
    return text +
           "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = " + std::to_string(swell) +
           "\n";
  };
  const auto highest = [&](double swell) {
    c.file("surface.toml", surface(swell));
    c.file("s.toml", scene("file = \"surface.toml\"\n"));
    const CliResult r = c.run({"deform", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(report(c, "out")["targets"][0]["rms"].get<double>() < 0.5);
    for (const auto& f : report(c, "out")["features"])
      CHECK(f["max_rigid_error"].get<double>() < 1e-12);
    return batten::MeshFile::read(c / "out/plate-deformed.obj")
        .shells()
        .points.col(2)
        .cwiseAbs()
        .maxCoeff();
  };
  const double one = highest(20), two = highest(40);
  CHECK(one > 1);
  CHECK(two == Approx(2 * one).epsilon(0.05));
}
