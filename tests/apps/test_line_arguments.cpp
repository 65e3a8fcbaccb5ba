// SPDX-License-Identifier: MPL-2.0
// Curves as users write them: arcs of few points, keywords for curves, copies, explicit corners.
#include <cmath>
#include <numbers>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

using std::numbers::pi;

std::string arc_points(int count, double y, bool backwards) {
  std::string text = "points = [";
  for (int i = 0; i < count; ++i) {
    const double t = pi * (backwards ? count - 1 - i : i) / (count - 1);
    text += "[" + std::to_string(50 * std::cos(t)) + ", " + std::to_string(y) + ", " +
            std::to_string(50 * std::sin(t)) + "],";
  }
  return text + "]\n";
}

std::string half_cylinder_between(const std::string& front, const std::string& back) {
  return "unit = \"mm\"\n[[curve]]\nname = \"front\"\n" + front +
         "[[curve]]\nname = \"left\"\npoints = [[-50,0,0], [-50,120,0]]\n"
         "[[curve]]\nname = \"back\"\n" +
         back +
         "[[curve]]\nname = \"right\"\npoints = [[50,120,0], [50,0,0]]\n"
         "[mesh]\nedge_length = 10\n[skin]\nfair = \"variation\"\n";
}

}  // namespace

TEST_CASE("arcs of five, nine and seventeen points are one half cylinder", "[apps][curves]") {
  const double area = pi * 50 * 120;
  for (const int count : {5, 9, 17}) {
    INFO(count);
    const CliCase c("arcs");
    c.file("s.toml",
           half_cylinder_between(arc_points(count, 0, false), arc_points(count, 120, true)));
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto report = batten_test::report(c, "out");
    CHECK(report["curves"]["count"] == 4);
    CHECK(report["surface"]["area"].get<double>() == Approx(area).epsilon(3e-4));
    CHECK(report["surface"]["max_curve_deviation"].get<double>() < 0.02);
    CHECK(
        (r.out.find("5 points, where the curve turns by up to 45 degrees, interpreted as smooth") !=
         std::string::npos) == (count == 5));
    fs::remove_all(c / "out");
  }
}

TEST_CASE("keys of curves make the same half cylinder, and copies of its arc", "[apps][curves]") {
  const CliCase c("curve_words");
  for (const std::string& back :
       {std::string("arc = [[50,120,0], [0,120,50], [-50,120,0]]\n"),
        std::string("copy = \"front\"\ntranslate = [0,120,0]\n"),
        std::string("copy = \"front\"\nmirror = {normal = [0,1,0], origin = [0,60,0]}\n"),
        std::string("ellipse = {centre = [0,120,0], radii = [50,50], normal = [0,1,0], angles = "
                    "[0,-180]}\n")}) {
    INFO(back);
    c.file("s.toml", half_cylinder_between(
                         "arc = {centre = [0,0,0], radius = 50, normal = [0,-1,0], angles = "
                         "[0,180]}\n",
                         back));
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(report(c, "out")["surface"]["area"].get<double>() == Approx(pi * 50 * 120).epsilon(3e-4));
    fs::remove_all(c / "out");
  }
}

TEST_CASE("a lid with a circular hole, a rectangle with round corners", "[apps][curves]") {
  const CliCase c("lid");
  const std::string hole =
      "[[curve]]\nname = \"hole\"\nrole = \"hole\"\ncircle = {centre = [10,5,0], radius = 12}\n";
  c.file(
      "s.toml",
      "unit = \"mm\"\n[[curve]]\nname = \"rim\"\nrectangle = {centre = [0,0,0], size = [100,60], "
      "radius = 8}\n" +
          hole);
  const CliResult r = c.run({"run", "s.toml", "--out", "out"});
  INFO(r.err);
  REQUIRE(r.code == 0);
  const double area = 100 * 60 - (4 - pi) * 64 - pi * 144;
  CHECK(report(c, "out")["surface"]["area"].get<double>() == Approx(area).epsilon(3e-4));
}

TEST_CASE("corners are stated by the numbers of points", "[apps][curves]") {
  const CliCase c("stated");
  const std::string rest =
      "[[curve]]\nname = \"b\"\npoints = [[40,0,0],[40,30,0]]\n"
      "[[curve]]\nname = \"c\"\npoints = [[40,30,0],[0,30,0]]\n"
      "[[curve]]\nname = \"d\"\npoints = [[0,30,0],[0,0,0]]\n";
  const std::string keel =
      "unit = \"mm\"\n[[curve]]\nname = \"keel\"\npoints = "
      "[[0,0,0],[10,-1,0],[20,-2,0],[30,-1,0],[40,0,0]]\n";
  for (const auto& [corners, lines] : {std::pair("", 4),
                                       {"corners = [3]\n", 5},
                                       {"corners = \"none\"\n", 4},
                                       {"corners = \"all\"\n", 7}}) {
    INFO(corners);
    c.file("s.toml", keel + corners + rest);
    const CliResult r = c.run({"run", "s.toml", "--out", "out"});
    INFO(r.err);
    REQUIRE(r.code == 0);
    CHECK(report(c, "out")["curves"]["count"] == lines);
    fs::remove_all(c / "out");
  }
  c.fails(keel + "corners = [6]\n" + rest, 1, {"s.toml:5:", "found 6", "1 to 5"});
  c.fails(keel + "corners = \"som\"\n" + rest, 1, {"found the word 'som'", "all, none"});
}

TEST_CASE("keys that describe no curve are refused with their position", "[apps][curves]") {
  const CliCase c("wrong_words");
  const auto refused = [&](const std::string& shape, const std::vector<std::string>& parts) {
    std::vector<std::string> all = {"s.toml:4:"};
    all.insert(all.end(), parts.begin(), parts.end());
    c.fails("unit = \"mm\"\n[[curve]]\nname = \"a\"\n" + shape + "\n", 1, all);
  };
  refused("arc = [[0,0,0],[1,0,0],[2,0,0]]", {"three collinear points"});
  refused("arc = [[0,0,0],[1,0,0]]", {"2 points", "3, its start"});
  refused("circle = {centre = [0,0,0], radius = -2}", {"radius -2", "above 0"});
  refused("circle = {centre = [0,0,0], radus = 2}", {"did you mean 'radius'"});
  refused("rectangle = {centre = [0,0,0], size = [10,4], radius = 3}", {"0 to 2"});
  refused("spline = {poles = [[0,0,0],[1,0,0]]}", {"2 poles for degree 3"});
  refused("copy = \"b\"", {"in the same place", "mirror"});
  refused("copy = \"b\"\ntranslate = [1,0,0]", {"a copy of 'b'"});
  refused("copy = \"a\"\ntranslate = [1,0,0]", {"copy of itself"});
  refused("translate = [1,0,0]\ncircle = {centre = [0,0,0], radius = 1}", {"without 'copy'"});
}
