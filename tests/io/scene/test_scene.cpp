// SPDX-License-Identifier: MPL-2.0
// Scenes: their interpretation, and the message for every error.
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "batten/io/files/text.h"
#include "batten/io/report/report.h"
#include "batten/io/scene/scene.h"
#include "batten/tests/support/catch.h"

using namespace batten;

namespace {

const std::string kSmall = R"(unit = "mm"
[[curve]]
name = "rim"
points = [[0,0,0], [1,0,0], [1,1,0], [0,0,0]]
)";

/// The message for a scene, "" if it is accepted.
std::string error_message_of(const std::string& text) {
  try {
    parse_scene(text, "s.toml");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

void check_error(const std::string& text, const std::vector<std::string>& parts) {
  const std::string message = error_message_of(text);
  for (const auto& part : parts) {
    INFO("message: " << message << "\nexpected in it: " << part);
    CHECK(message.find(part) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("a scene with everything in it is read as it is written", "[io][scene]") {
  const Scene s = parse_scene(R"(
name = "hood"
unit = "in"
fit_tolerance = 0.05
corner_angle = 30
[[curve]]
name = "cowl"
file = "lines/cowl.csv"
unit = "mm"
[[curve]]
name = "curve"
bezier = [[0,0,0],[1,0,0],[2,1,0],[3,3,3]]
role = "inner"
[[curves]]
file = "hull.iges"
only = ["edge1", "edge3"]
inner = ["edge3"]
[skin]
alpha = 0.5
beta = [1, 2, 3]
load_units = "absolute"
boundary = "corners"

[mesh]
element = "z12"
mesher = "fan"
refine = 0
[[constraint]]
name = "peak"
type = "point"
at = [0,0,0]
to = [0,0,10]
range = 4
[[constraint]]
name = "flat"
type = "normal"
at = [1,0,0]
direction = [0,0,2]
[[load]]
name = "crown"
type = "pressure"
value = 3
min = 0
max = 10
[[load]]
name = "pull"
type = "point"
value = 2
at = [1,2,3]
direction = [0,0,-5]
[stress]
thickness = 0.8
young = 210000
supports = [ {curve = "cowl"}, {curve = "curve", type = "pinned"} ]
[output]
step = "hood.step"
calculix = "hood.inp"
[[picture]]
file = "hood.png"
show = "mean_curvature"
view = [10, 20]
mesh = true
[[sweep]]
parameter = "beta_vv"
values = [1, 2, 4]
columns = 3
file = "sweep.png"
)",
                              "dir/s.toml");
  CHECK(s.name == "hood");
  CHECK(s.unit == "in");
  CHECK(s.skin.options.tolerance == 0.05);
  CHECK(s.skin.options.corner_angle == 30);
  REQUIRE(s.lines.size() == 3);
  CHECK(s.lines[0].file == std::filesystem::path("dir/lines/cowl.csv"));
  CHECK(s.lines[0].unit == "mm");
  CHECK(s.lines[1].curve);
  CHECK(s.lines[1].role == CharacterLine::Role::Inner);
  CHECK(s.lines[2].name.empty());
  CHECK(s.lines[2].only[1].text == "edge3");
  CHECK(s.lines[2].inner[0].text == "edge3");
  CHECK(s.skin.options.element == TriangleElement::Z12);
  CHECK(s.skin.options.mesher == SkinOptions::Mesher::Fan);
  CHECK(s.skin.options.fan_refinements == 0);
  CHECK(s.skin.material.alpha == 0.5 * Mat2::Identity());
  CHECK(s.skin.material.beta == Vec3(1, 2, 3));
  CHECK(s.skin.units == LoadUnits::Absolute);
  CHECK(s.skin.boundary == SceneSkin::FixedBoundary::Corners);
  CHECK(s.constraints[0].goal == Vec3(0, 0, 10));
  CHECK(s.constraints[1].goal == Vec3(0, 0, 1));
  CHECK(s.loads[0].type == SceneLoad::Type::Pressure);
  CHECK(s.loads[0].value == 3);
  CHECK(s.loads[1].type == SceneLoad::Type::Point);
  CHECK(s.loads[1].value * s.loads[1].direction == Vec3(0, 0, -2));
  REQUIRE(s.stress);
  CHECK(s.stress->material.poisson == 0.3);
  using Kind = SceneStress::Support::Kind;
  CHECK(s.stress->supports[0].kind == Kind::Clamped);
  CHECK(s.stress->supports[1].kind == Kind::Pinned);
  CHECK(s.step == "hood.step");
  CHECK(s.vtp.empty());
  CHECK(s.pictures[0].look.field == PictureScene::Field::Mean);
  CHECK(s.pictures[0].look.azimuth == 10);
  CHECK(s.pictures[0].look.mesh);
  CHECK(s.sweeps[0].values == std::vector<double>{1, 2, 4});
}

TEST_CASE("missing keys of a scene have the documented defaults", "[io][scene]") {
  const Scene s = parse_scene(kSmall, "folder/panel.toml");
  CHECK(s.name == "panel");
  CHECK(s.skin.options.tolerance == 0);
  CHECK(s.skin.options.corner_angle == 20);
  CHECK(s.skin.options.element == TriangleElement::HCT);
  CHECK(s.skin.options.mesher == SkinOptions::Mesher::Delaunay);
  CHECK(s.skin.options.fan_refinements == -1);
  CHECK(s.skin.material.alpha.isZero());
  CHECK(s.skin.material.beta == Vec3::Ones());
  CHECK(s.skin.units == LoadUnits::Relative);
  CHECK(s.skin.boundary == SceneSkin::FixedBoundary::Lines);
  CHECK(s.parameters().size() == 2);
}

TEST_CASE("parameters can be set inside their ranges only", "[io][scene]") {
  Scene s = parse_scene(kSmall + R"([skin]
alpha = [1, 0.5, 1]
[[constraint]]
name = "peak"
type = "point"
at = [0,0,0]
to = [1,2,3]
range = 1
[[load]]
name = "crown"
type = "pressure"
value = 3
min = 0
max = 10
)",
                        "s.toml");
  std::vector<std::string> names;
  for (const auto& p : s.parameters()) names.push_back(p.name);
  CHECK(names == std::vector<std::string>{"crown", "peak.x", "peak.y", "peak.z", "alpha_uu",
                                          "alpha_uv", "alpha_vv", "beta"});
  s.set("crown", 10, "");
  CHECK(s.loads[0].value == 10);
  s.set("peak.y", 2.5, "");
  s.set("peak.y", 3, "");  // the range of the scene does not change
  CHECK(s.constraints[0].goal[1] == 3);
  s.set("beta", 4, "");
  CHECK(s.skin.material.beta == Vec3::Constant(4));
  s.set("alpha_uv", -0.25, "");
  CHECK(s.skin.material.alpha(1, 0) == -0.25);
  CHECK(s.skin.material.alpha(0, 1) == -0.25);

  const auto refused = [&](const std::string& name, double value) {
    try {
      s.set(name, value, "--set: ");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(refused("crown", 10.5) == "--set: found 10.5 for 'crown', expected a number from 0 to 10");
  CHECK(refused("peak.y", 3.5).find("from 1 to 3") != std::string::npos);
  CHECK(refused("crwn", 1).find("did you mean 'crown'?") != std::string::npos);
  CHECK(refused("beta", -1).find("from 0 up") != std::string::npos);
  CHECK(refused("alpha_uv", 3).find("alpha ≥ 0") != std::string::npos);
  CHECK_FALSE(refused("crown", std::nan("")).empty());
  CHECK(s.loads[0].value == 10);
  CHECK(s.skin.material.alpha(0, 1) == -0.25);
}

TEST_CASE("an invalid scene is refused with position, what was found and a remedy", "[io][scene]") {
  check_error("", {"s.toml:1:1: found an empty file"});
  check_error("  \n\t\n", {"s.toml:1:1: found an empty file"});
  check_error("unit = \"mm\"\nname = hood\n", {"s.toml:2:8: not TOML"});
  check_error("name = \"x\"\n", {"s.toml:1:1: found no 'unit' in the scene, expected 'unit'"});
  check_error("unit = \"mn\"\n",
              {"s.toml:1:8: found the unit 'mn'", "mm, cm, m, in, ft", "did you mean 'mm'?"});
  check_error("unit = \"mm\"\n", {"found no curves, expected [[curve]]"});
  check_error("unit = 3\n", {"s.toml:1:8: found 3 for 'unit', expected a text in quotes"});
  check_error("fit_tolerence = 1\n" + kSmall, {"s.toml:1:1: found key 'fit_tolerence' in the scene",
                                               "did you mean 'fit_tolerance'?"});
  check_error("fit_tolerance = -1\n" + kSmall,
              {"s.toml:1:17: found -1, expected a number above 0 for 'fit_tolerance'"});
  check_error("fit_tolerance = nan\n" + kSmall, {"s.toml:1:17: found nan (not a number)"});
  check_error("fit_tolerance = \"fine\"\n" + kSmall, {"s.toml:1:17: found the text \"fine\""});
  check_error("corner_angle = 200\n" + kSmall, {"s.toml:1:16: found 200, expected less than 180"});
  check_error("curve = 3\n" + kSmall.substr(0, 12),
              {"s.toml:1:9: found 3 for 'curve'", "[[curve]]"});
}

TEST_CASE("errors in curves are reported", "[io][scene]") {
  const std::string head = "unit = \"mm\"\n[[curve]]\nname = \"a\"\n";
  check_error(head, {"s.toml:3:8: found no shape for the curve 'a'",
                     "expected one of: file, points, bezier"});
  check_error(head + "points = [[0,0,0]]\n", {"s.toml:4:10: found 1 points, expected 2"});
  check_error(head + "points = [[0,0,0],[1,2]]\n",
              {"s.toml:4:19: found a list of 2 values, expected a list of points"});
  check_error(head + "points = [[0,0,0],[1,inf,2]]\n",
              {"s.toml:4:22: found an infinite number, expected a number"});
  check_error(head + "bezier = [[0,0,0],[1,1,1]]\n", {"found 2 points, expected 4 control points"});
  check_error(head + "points = [[0,0,0],[1,1,1]]\nfile = \"a.csv\"\n", {"more than one shape"});
  check_error(head + "file = \"a.csv\"\nrole = \"iner\"\n",
              {"s.toml:5:8: found the word 'iner' for 'role'", "did you mean 'inner'?"});
  check_error(head + "points = [[0,0,0],[1,1,1]]\n[[curve]]\nname = \"a\"\nfile = \"b.csv\"\n",
              {"s.toml:6:8: found the curve name 'a' again (first in line 3)"});
  check_error("unit = \"mm\"\n[[curves]]\nfile = \"a.iges\"\nonly = [\"x\"]\nskip = [\"y\"]\n",
              {"s.toml:5:8: found both 'only' and 'skip'"});
}

TEST_CASE("errors in sections are reported", "[io][scene]") {
  check_error(kSmall + "[mesh]\nedge_lenght = 4\n",
              {"s.toml:6:1: found key 'edge_lenght' in [mesh]", "did you mean 'edge_length'?"});
  check_error(kSmall + "[mesh]\nelement = \"HCT\"\n", {"expected one of: hct, z12"});
  check_error(kSmall + "[mesh]\nrefine = 2\n", {"s.toml:6:10:", "only with mesher = \"fan\""});
  check_error(kSmall + "[skin]\nbeta = [1,1]\n",
              {"found a list of 2 values, expected [b11, b12, b22]"});
  check_error(kSmall + "[skin]\nbeta = -1\n", {"s.toml:6:8:", "expected beta ≥ 0"});
  check_error(kSmall + "[skin]\nbeta = 0\n", {"expected alpha or beta above 0"});
  check_error(kSmall + "[skin]\nalpha = [1, 2, 1]\n", {"s.toml:6:9:", "expected alpha ≥ 0"});
  check_error(kSmall + "[[load]]\nname = \"p\"\ntype = \"pressure\"\nvalue = 3\nmax = 2\n",
              {"s.toml:8:9: found 3, expected a value up to 2"});
  check_error(kSmall + "[[load]]\nname = \"p\"\ntype = \"uniform\"\nvalue = 3\n",
              {"found no 'direction' in [[load]]"});
  check_error(kSmall + "[[load]]\nname = \"beta\"\ntype = \"pressure\"\nvalue = 3\n",
              {"found the load name 'beta'"});
  check_error(kSmall +
                  "[[constraint]]\nname = \"c\"\ntype = \"normal\"\nat = [0,0,0]\n"
                  "direction = [0,0,0]\n",
              {"s.toml:9:13: found [0, 0, 0], expected a direction"});
  check_error(kSmall +
                  "[[constraint]]\nname = \"c\"\ntype = \"point\"\nat = [0,0,0]\n"
                  "direction = [0,0,1]\nto = [0,0,0]\n",
              {"'direction'", "it only with type = \"normal\" or \"tangent\""});
  check_error(kSmall + "[output]\nstep = \"../a.step\"\n", {"a file name without folders"});
  check_error(kSmall + "[output]\nstep = \"a.stl\"\n", {"a file name that ends in .step, .stp"});
  check_error(kSmall + "[output]\nvtp = \"a.vtp\"\ncalculix = \"a.inp\"\n",
              {"expected a section [stress]"});
  check_error(kSmall + "[[picture]]\nfile = \"a.png\"\n[[picture]]\nfile = \"a.png\"\n",
              {"found the file name 'a.png' again (first in line 6)"});
  check_error(kSmall + "[[picture]]\nfile = \"a.png\"\nmesh = 1\n", {"expected true or false"});
  check_error(kSmall + "[[sweep]]\nparameter = \"bta\"\nvalues = [1]\nfile = \"a.png\"\n",
              {"s.toml:6:13: found parameter 'bta'", "did you mean 'beta'?"});
  check_error(kSmall + "[[sweep]]\nparameter = \"beta\"\nvalues = [1,-1]\nfile = \"a.png\"\n",
              {"s.toml:7:10: found -1 for 'beta', expected a number from 0 up"});
  check_error(kSmall + "[stress]\nthickness = 1\nyoung = 1\npoisson = 0.5\n",
              {"found 0.5, expected a number above -1 and below 0.5"});
  check_error(kSmall + "[stress]\nthickness = 1\nyoung = 1\n", {"found no supports"});
}

TEST_CASE("units are what they are in metres", "[io][scene]") {
  CHECK(unit_in_metres("mm") == 0.001);
  CHECK(unit_in_metres("ft") == Approx(12 * unit_in_metres("in")).epsilon(1e-15));
  CHECK_THROWS_AS(unit_in_metres("yard"), InputError);
}

TEST_CASE("a report says when a number could not be computed", "[io][scene][report]") {
  Report report;
  report.name = "x";
  report.lines.push_back({"rim", CharacterLine::Role::Outline, false, 1, 0.25, 5});
  report.parameters.push_back({"p", 1, 0, std::numeric_limits<double>::infinity()});
  CHECK(non_finite_numbers(report).empty());
  auto json = nlohmann::json::parse(to_json(report));
  CHECK(json["curves"]["max_deviation"] == 0.25);
  CHECK(json["failed_checks"].empty());
  CHECK_FALSE(json.contains("step"));
  CHECK_FALSE(json["parameters"][0].contains("max"));

  report.surface.quality.area = std::nan("");
  report.lines[0].deviation = std::nan("");
  std::vector<std::string> names;
  for (const auto& m : non_finite_numbers(report)) names.push_back(m.what);
  CHECK(names == std::vector<std::string>{"curves.max_deviation", "curves.each.rim.deviation",
                                          "surface.area"});
  json = nlohmann::json::parse(to_json(report));
  CHECK(json["surface"]["area"] == "nan");
  CHECK(json["curves"]["max_deviation"] == "nan");
}
