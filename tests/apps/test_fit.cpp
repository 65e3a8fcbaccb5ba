// SPDX-License-Identifier: MPL-2.0
// batten fit: existing surfaces become models.
#include <cmath>
#include <set>

#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/catch.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A block of 40 × 30 × 20 with a hill of `n` × `n` quads as its upper face.
std::string block(int n, double hill, double unit = 1) {
  std::string text;
  const auto put = [&](double x, double y, double z) {
    text += "v " + std::to_string(unit * x) + " " + std::to_string(unit * y) + " " +
            std::to_string(unit * z) + "\n";
  };
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double s = 1.0 * i / n, t = 1.0 * j / n;
      put(40 * s, 30 * t, 20 + hill * 16 * s * (1 - s) * t * (1 - t));
    }
  const int up = (n + 1) * (n + 1);
  for (const auto& [x, y] : {std::pair{0, 0}, {40, 0}, {40, 30}, {0, 30}}) put(x, y, 0);
  const auto v = [n](int i, int j) { return std::to_string(j * (n + 1) + i + 1) + " "; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      text += "f " + v(i, j) + v(i + 1, j) + v(i + 1, j + 1) + v(i, j + 1) + "\n";
  const auto low = [&](int k) { return std::to_string(up + k) + " "; };
  text += "f " + low(4) + low(3) + low(2) + low(1) + "\n";
  std::string sides[4];
  for (int i = n; i >= 0; --i) {
    sides[0] += v(i, 0);
    sides[1] += v(n, i);
    sides[2] += v(n - i, n);
    sides[3] += v(0, n - i);
  }
  const int ends[4][2] = {{1, 2}, {2, 3}, {3, 4}, {4, 1}};
  for (int k = 0; k < 4; ++k) text += "f " + low(ends[k][0]) + low(ends[k][1]) + sides[k] + "\n";
  return text;
}

}  // namespace

TEST_CASE("a mesh's creases and patches become a model at the mesh", "[apps][fit]") {
  const CliCase c("fit_mesh");
  c.file("block.obj", block(24, 3));
  const CliResult r = c.run({"fit", "block.obj", "--out", "out", "--fit-tolerance", "0.03"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  CHECK(j["faces"].size() == 6);
  const auto& target = j["target"];
  CHECK(target["reached"].get<bool>());
  CHECK(target["before"]["max"].get<double>() > 1);
  CHECK(target["to_target"]["max"].get<double>() <= 0.03);
  CHECK(target["from_target"]["max"].get<double>() <= 0.03);
  CHECK(target["distant_curves"].empty());
  CHECK(j["step"]["faces"].get<int>() == 6);
  // Round trip through STEP: the edges of its faces, fitted to its faces.
  const CliResult again =
      c.run({"fit", "out/block.step", "--out", "again", "--fit-tolerance", "0.03"});
  INFO(again.out << again.err);
  CHECK(again.code == 0);
  CHECK(report(c, "again")["target"]["from_target"]["max"].get<double>() <= 0.03);
}

TEST_CASE("loads bend the fitted shape, in any unit", "[apps][fit]") {
  const CliCase c("fit_scene");
  c.file("block.obj", block(16, 3, 1e-3));
  const std::string lines =
      "unit = \"mm\"\n[[curve]]\nname = \"a\"\npoints = [[0,0,20],[40,0,20]]\n"
      "[[curve]]\nname = \"b\"\npoints = [[40,0,20],[40,30,20]]\n"
      "[[curve]]\nname = \"c\"\npoints = [[40,30,20],[0,30,20]]\n"
      "[[curve]]\nname = \"d\"\npoints = [[0,30,20],[0,0,20]]\n";
  const std::string target =
      "[[target]]\nfile = \"block.obj\"\nunit = \"m\"\nfit_tolerance = 0.1\n";
  const auto moved = [&](const std::string& more) {
    c.file("s.toml", lines + target + more);
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.out << r.err);
    // The block has five more faces, far from the model. This is reported.
    CHECK(r.code == 0);
    const auto j = report(c, "out");
    CHECK(j["target"]["to_target"]["max"].get<double>() <= 0.1);
    return j["surface"]["max_displacement"].get<double>();
  };
  CHECK(moved("") == Approx(0).margin(0.2));
  CHECK(moved("[[load]]\nname = \"p\"\ntype = \"pressure\"\nvalue = 50\n") > 0.3);
}

TEST_CASE("a cage is fitted by its limit", "[apps][fit]") {
  const CliCase c("fit_cage");
  c.file("cage.obj",
         "v 0 0 0\nv 10 0 0\nv 20 0 0\nv 0 10 0\nv 10 10 9\nv 20 10 0\nv 0 20 0\n"
         "v 10 20 0\nv 20 20 0\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n");
  c.file("rim.csv",
         "x,y,z\n0,0,0\n20,0,0\n\n20,0,0\n20,20,0\n\n20,20,0\n0,20,0\n\n0,20,0\n0,0,0\n");
  const CliResult r = c.run({"fit", "cage.obj", "--cage", "--curves", "rim.csv", "--out", "out",
                             "--fit-tolerance", "0.01"});
  INFO(r.out << r.err);
  CHECK(r.code == 0);
  CHECK(report(c, "out")["target"]["before"]["max"].get<double>() > 1);
}

TEST_CASE("creases of a cage are in its limit, and a tag that is not known is named",
          "[apps][fit]") {
  const CliCase c("fit_creases");
  // A roof of two by two quads with a sharp ridge.
  const std::string roof =
      "v 0 0 0\nv 10 0 6\nv 20 0 0\nv 0 10 0\nv 10 10 6\nv 20 10 0\nv 0 20 0\nv 10 20 6\n"
      "v 20 20 0\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n";
  c.file("smooth.obj", roof);
  c.file("sharp.obj", roof +
                          "t crease 2/1/0 1 4 10\nt crease 2/1/0 4 7 10\n"
                          "t corner 2/1/0 1 7 10\n");
  c.file("hole.obj", roof + "t hole 1/0/0 2\n");
  c.file("lines.csv",
         "x,y,z\n0,0,0\n10,0,6\n\n10,0,6\n20,0,0\n\n20,0,0\n20,20,0\n\n20,20,0\n10,20,6\n\n"
         "10,20,6\n0,20,0\n\n0,20,0\n0,0,0\n\n10,0,6\n10,20,6\n");
  const auto fit = [&](const std::string& cage) {
    return c.run({"fit", cage, "--cage", "--curves", "lines.csv", "--out", cage + ".out",
                  "--fit-tolerance", "0.01"});
  };
  const CliResult sharp = fit("sharp.obj");
  INFO(sharp.out << sharp.err);
  CHECK(sharp.code == 0);  // two planes
  CHECK(fit("smooth.obj").code == 4);
  CHECK(report(c, "smooth.obj.out")["target"]["from_target"]["max"].get<double>() > 0.1);
  const CliResult hole = fit("hole.obj");
  CHECK(hole.code == 1);
  CHECK(hole.err.find("hole.obj:14:") != std::string::npos);
  CHECK(hole.err.find("the tag 'hole'") != std::string::npos);
}

TEST_CASE("invalid targets are refused with their position", "[apps][fit]") {
  const CliCase c("fit_errors");
  const std::string lines =
      "unit = \"mm\"\n[[curve]]\nname = \"a\"\npoints = "
      "[[0,0,0],[4,0,0],[4,3,0],[0,3,0],[0,0,0]]\n";
  c.file("flat.obj", "v 0 0 0\nv 4 0 0\nv 4 3 0\nf 1 2 3\n");
  c.file("empty.obj", "v 0 0 0\n");
  const auto refused = [&](const std::string& target, const std::vector<std::string>& words) {
    c.fails(lines + "[[target]]\n" + target, 1, words);
  };
  refused("file = \"none.stl\"\n", {"none.stl"});
  refused("file = \"empty.obj\"\n", {"s.toml:6:8: ", "empty.obj"});
  refused("file = \"flat.obj\"\nfit_tolerance = -1\n", {"'fit_tolerance'"});
  refused("file = \"flat.obj\"\nunit = \"parsec\"\n", {"parsec"});
  refused("file = \"flat.obj\"\ncage = \"loop\"\n", {"catmull-clark"});
  refused("file = \"flat.obj\"\n[skin]\nfair = \"variation\"\n", {"target"});
  const CliResult r = c.run({"fit", "empty.obj", "--out", "out"});
  CHECK(r.code == 1);
  CHECK_FALSE(fs::exists(c / "out"));
}

TEST_CASE(
    "names of curves and faces survive the way into a deck and back, and fit writes its scene",
    "[apps][fit]") {
  const CliCase c("fit_names");
  c.file("plate.csv",
         "curve,x,y,z\nleft,0,0,0\nleft,0,25,4\nleft,0,50,0\nright,100,0,0\nright,100,25,4\n"
         "right,100,50,0\nfront,0,0,0\nfront,50,0,10\nfront,100,0,0\nback,0,50,0\nback,50,50,10\n"
         "back,100,50,0\nmiddle,50,0,10\nmiddle,50,25,16\nmiddle,50,50,10\n");
  c.file("plate.toml",
         "unit = \"mm\"\n[[curves]]\nfile = \"plate.csv\"\n[output]\ncalculix = \"plate.inp\"\n"
         "[stress]\nmaterial = \"steel\"\nthickness = 1\npressure = 0.001\n"
         "supports = [{curve = \"left\", type = \"clamped\"}]\n");
  REQUIRE(c.run({"run", "plate.toml", "--out", "out"}).code == 0);
  const CliResult r = c.run({"fit", "out/plate.inp", "--out", "fitted", "--fit-tolerance", "0.05"});
  INFO(r.out << r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "fitted");
  std::set<std::string> curves, faces;
  for (const auto& face : j["faces"]) faces.insert(face["name"].get<std::string>());
  for (const auto& curve : j["curves"]["each"]) curves.insert(curve["name"].get<std::string>());
  CHECK(faces == std::set<std::string>{"FACE_1", "FACE_2"});
  CHECK(curves ==
        std::set<std::string>{"LEFT", "RIGHT", "MIDDLE", "FRONT_1", "FRONT_2", "BACK_1", "BACK_2"});
  // The curve between both faces is no crease, as in the original.
  CHECK(r.out.find("0 creases (G0), 1 smooth") != std::string::npos);

  // The written scene is the scene of the run; a changed one is kept.
  const std::string scene = contents(c / "fitted/plate.toml");
  setenv("SOURCE_DATE_EPOCH", "0", 1);
  REQUIRE(c.run({"fit", "out/plate.inp", "--out", "fitted", "--fit-tolerance", "0.05"}).code == 0);
  REQUIRE(c.run({"run", "fitted/plate.toml", "--out", "again"}).code == 0);
  unsetenv("SOURCE_DATE_EPOCH");
  CHECK(contents(c / "fitted/plate.step") == contents(c / "again/plate.step"));
  CHECK(contents(c / "fitted/plate.toml") == scene);
  c.file("fitted/plate.toml", scene + "# mine\n");
  const CliResult kept =
      c.run({"fit", "out/plate.inp", "--out", "fitted", "--fit-tolerance", "0.05"});
  CHECK(kept.code == 0);
  CHECK_THAT(kept.err, Contains("plate.toml is kept"));
  CHECK(contents(c / "fitted/plate.toml") == scene + "# mine\n");
}
