// SPDX-License-Identifier: MPL-2.0
// Scenes for sculpting: areas, stiffness fields, offsets, rules, values over time, and every error
// in them.
#include <cmath>

#include "batten/io/scene/scene.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;

namespace {

// Ten lines; the text of a test starts in line 11.
const std::string kLines = R"(unit = "mm"
[[curve]]
name = "rim"
points = [[0,0,0], [4,0,0], [4,3,0], [0,3,0], [0,0,0]]
[[curve]]
name = "spine"
points = [[1,1,0], [3,1,0]]
role = "inner"
[skin]
beta = 2
)";

Scene scene_with(const std::string& text) { return parse_scene(kLines + text, "s.toml"); }

void check_refusal(const std::string& text, const std::vector<std::string>& parts) {
  const std::string message = batten_test::error_message([&] { scene_with(text); });
  for (const auto& part : parts) {
    INFO(text << "\nmessage: " << message << "\nexpected in it: " << part);
    CHECK(message.find(part) != std::string::npos);
  }
}

std::string load(const std::string& type, const std::string& rest) {
  return "[[load]]\nname = \"l\"\ntype = \"" + type + "\"\nvalue = 1\n" + rest + "\n";
}

const Parameter* find(const std::vector<Parameter>& list, const std::string& name) {
  for (const Parameter& p : list)
    if (p.name == name) return &p;
  return nullptr;
}

double value_of(const Scene& scene, const std::string& name) {
  const auto list = scene.parameters();
  const Parameter* p = find(list, name);
  REQUIRE(p);
  return p->value;
}

}  // namespace

TEST_CASE("all kinds of loads are read as they are written", "[io][scene][sculpt]") {
  const Scene s = scene_with(R"(
[[load]]
name = "swell"
type = "pressure"
value = [[0, 5], [2, 9]]
max = 10
near = "spine"
radius = 0.5
[[load]]
name = "push"
type = "uniform"
value = 2
direction = [0, 0, 3]
paint = [{ at = [1, 1, 0], radius = 1 }, { at = [2, 1, 0], radius = 0.5, strength = -1 }]
[[load]]
name = "weight"
type = "gravity"
value = 1
direction = [0, 0, -2]
[[load]]
name = "along"
type = "line"
value = 1
curve = "spine"
direction = [0, 1, 0]
[[load]]
name = "pull"
type = "attractors"
value = 3
at = [[1, 1, 0], [2, 2, 0]]
to = [[1, 1, 5], [2, 2, 5]]
rest_length = 0.25
falloff = 4
[[load]]
name = "rail"
type = "attractors"
value = 3
at = [[1, 1, 0]]
curve = "spine"
[[load]]
name = "floor"
type = "attractors"
value = 3
at = [[1, 1, 0]]
plane = { origin = [0, 0, -1], normal = [0, 0, 2] }
[[load]]
name = "measured"
type = "point_cloud"
value = 3
file = "points.csv"
)");
  REQUIRE(s.loads.size() == 8);
  using Type = SceneLoad::Type;
  const SceneLoad& swell = s.loads[0];
  CHECK(swell.type == Type::Pressure);
  CHECK(swell.value == 5);
  REQUIRE(swell.keyframes.size() == 2);
  CHECK(swell.keyframes[1].time == 2);
  CHECK(swell.keyframes[1].value == 9);
  const auto& near = std::get<Area::NearLine>(swell.area.area.where);
  CHECK(near.line == "spine");
  CHECK(near.radius == 0.5);
  const auto& painted = std::get<Area::Painted>(s.loads[1].area.area.where);
  REQUIRE(painted.strokes.size() == 2);
  CHECK(painted.strokes[0].strength == 1);
  CHECK(painted.strokes[1].at == Vec3(2, 1, 0));
  CHECK(painted.strokes[1].strength == -1);
  CHECK(s.loads[1].direction == Vec3(0, 0, 1));
  CHECK(s.loads[2].type == Type::Gravity);
  CHECK(s.loads[2].direction == Vec3(0, 0, -1));
  CHECK(s.loads[3].type == Type::Line);
  CHECK(s.loads[3].line.text == "spine");
  CHECK(s.loads[4].type == Type::AttractorSprings);
  CHECK(s.loads[4].pulls.at.size() == 2);
  CHECK(std::get<Load::AttractorSprings::TargetPoints>(s.loads[4].pulls.target).to[1] ==
        Vec3(2, 2, 5));
  CHECK(s.loads[4].pulls.rest_length == 0.25);
  CHECK(s.loads[4].pulls.falloff == 4);
  CHECK(s.loads[4].min == 0);
  CHECK(s.loads[5].curve.text == "spine");
  CHECK(std::get<Load::AttractorSprings::Plane>(s.loads[6].pulls.target).normal == Vec3(0, 0, 1));
  CHECK(s.loads[7].type == Type::PointCloudSprings);
  CHECK(s.loads[7].file == "points.csv");
  CHECK(s.is_sculpted());
}

TEST_CASE("a scene is sculpted if more than curves acts on it", "[io][scene][sculpt]") {
  CHECK_FALSE(scene_with("").is_sculpted());
  CHECK(scene_with(load("pressure", "")).is_sculpted());
  CHECK(scene_with("[[parameter]]\nname = \"p\"\nvalue = 1\n").is_sculpted());
  CHECK(scene_with("[[constraint]]\nname = \"c\"\ntype = \"curve_normal\"\ncurve = \"spine\"\n")
            .is_sculpted());
}

TEST_CASE("stiffness fields, offsets, curve normals and motion are read as they are written",
          "[io][scene][sculpt]") {
  const Scene s = scene_with(R"(
[[stiffness]]
name = "stiff spine"
type = "beta"
value = 40
min = 0
near = "spine"
radius = 1
along = "spine"
[[stiffness]]
name = "skin"
type = "alpha"
value = 1
parametric_direction = [3, 4]
[[offset]]
name = "rib"
curve = "spine"
value = 0
min = -2
max = 2
direction = [0, 0, 5]
fade = 0.25
[[offset]]
name = "rim"
curve = "rim.1"
value = 0
[[constraint]]
name = "held"
type = "curve_normal"
curve = "spine"
[[constraint]]
name = "flat"
type = "curve_normal"
curve = "spine"
normal = [0, 0, 3]
[motion]
density = 2
damping = 0
theta = 0.5
)");
  REQUIRE(s.weights.size() == 2);
  CHECK(s.weights[0].kind == StiffnessField::Kind::Bending);
  CHECK(std::get<LocatedString>(*s.weights[0].along).text == "spine");
  CHECK(s.weights[1].kind == StiffnessField::Kind::Stretching);
  CHECK((std::get<Vec2>(*s.weights[1].along) - Vec2(0.6, 0.8)).norm() < 1e-15);
  REQUIRE(s.moves.size() == 2);
  CHECK(*s.moves[0].direction == Vec3(0, 0, 1));
  CHECK(s.moves[0].fade == 0.25);
  CHECK(s.moves[0].max == 2);
  CHECK_FALSE(s.moves[1].direction);
  REQUIRE(s.constraints.size() == 2);
  CHECK(s.constraints[0].keep_tangent_planes);
  CHECK_FALSE(s.constraints[1].keep_tangent_planes);
  CHECK(s.constraints[1].goal == Vec3(0, 0, 1));
  CHECK(s.motion.density == 2);
  CHECK(s.motion.damping == 0);
  CHECK(s.motion.theta == 0.5);
  // Normals along curves have no parameters.
  const auto parameters = s.parameters();
  CHECK(find(parameters, "stiff spine"));
  CHECK(find(parameters, "rib"));
  CHECK_FALSE(find(parameters, "held.x"));
}

TEST_CASE("one parameter drives others, from their own values", "[io][scene][sculpt]") {
  Scene s = scene_with(R"(
[[parameter]]
name = "bolder"
value = 0.5
min = 0
max = 1
drives = [{ name = "swell", factor = 200 }, { name = "rib", factor = 10, offset = -1 }, { name = "beta", factor = 2 }]
[[parameter]]
name = "finer"
value = 0
drives = [{ name = "swell", factor = -1 }]
[[load]]
name = "swell"
type = "pressure"
value = 6
max = 150
[[offset]]
name = "rib"
curve = "spine"
value = 0
)");
  CHECK(value_of(s, "swell") == 106);
  CHECK(value_of(s, "rib") == 4);
  CHECK(value_of(s, "beta") == 3);
  s.set("bolder", 0, "");
  s.set("finer", 2, "");
  CHECK(value_of(s, "swell") == 4);
  CHECK(value_of(s, "rib") == -1);
  s.set("bolder", 1, "");  // clamped to its range
  CHECK(value_of(s, "swell") == 150);
  const std::string message =
      batten_test::error_message([&] { s.set("swell", 1, "--set swell=1: "); });
  CHECK(message ==
        "--set swell=1: found a value for 'swell', expected one for 'bolder', which "
        "drives it");
}

TEST_CASE("a value over time is set to one that stands", "[io][scene][sculpt]") {
  Scene s = scene_with(
      "[[load]]\nname = \"swell\"\ntype = \"pressure\"\nvalue = [[-1, 0], [1, 4]]\nmax = 5\n");
  CHECK(value_of(s, "swell") == 2);
  CHECK(s.named_values()[0].keyframes.size() == 2);
  s.set("swell", 5, "");
  CHECK(value_of(s, "swell") == 5);
  CHECK(s.named_values()[0].keyframes.empty());
  CHECK(batten_test::error_message([&] { s.set("swell", 6, ""); }).find("up to 5") !=
        std::string::npos);
}

TEST_CASE("errors in loads are reported with their position", "[io][scene][sculpt]") {
  check_refusal(load("pressur", ""),
                {"s.toml:13:8: found the word 'pressur'",
                 "gravity, point, line, point_cloud, attractors", "did you mean 'pressure'?"});
  check_refusal(load("pressure", "neer = \"spine\""), {"s.toml:15:1: found key 'neer'", "'near'?"});
  check_refusal(load("pressure", "near = \"spien\"\nradius = 1"),
                {"s.toml:15:8: found the curve 'spien', expected one of: rim, spine",
                 "did you mean 'spine'?"});
  check_refusal(load("pressure", "near = \"spine\""), {"no 'radius'"});
  check_refusal(load("pressure", "radius = 1"), {"s.toml:15:10", "'radius' without 'near'"});
  check_refusal(load("pressure", "near = \"spine\"\nradius = 0"),
                {"s.toml:16:10: found 0", "a number above 0"});
  check_refusal(load("pressure", "near = \"rim\"\nradius = 1\npaint = [{at=[0,0,0], radius=1}]"),
                {"s.toml:17:9: found both 'near' and 'paint'"});
  check_refusal(load("pressure", "paint = []"), {"found no strokes"});
  check_refusal(load("pressure", "paint = [{at=[0,0,0], raduis=1}]"),
                {"s.toml:15:", "found key 'raduis' in [[paint]]", "did you mean 'radius'?"});
  check_refusal(load("pressure", "paint = [{at=[0,0,0], radius=-1}]"), {"found -1"});
  check_refusal(load("gravity", ""), {"found no 'direction'"});
  check_refusal(load("gravity", "direction = [0,0,1]\nnear = \"rim\"\nradius = 1"),
                {"s.toml:16:8: found 'near' for the load 'l'", "\"pressure\" or \"uniform\""});
  check_refusal(load("line", "direction = [0,0,1]"), {"found no 'curve' in [[load]]"});
  check_refusal(load("line", "direction = [0,0,1]\ncurve = \"rims\""),
                {"s.toml:16:9: found the curve 'rims'", "did you mean 'rim'?"});
  check_refusal(load("pressure", "curve = \"rim\""),
                {"s.toml:15:9", "it only with type = \"line\" or \"attractors\""});
  check_refusal(load("uniform", "direction = [0,0,1]\nat = [0,0,0]"),
                {"s.toml:16:6: found 'at' for the load 'l', expected it only with type = \"point\" "
                 "or \"attractors\""});
  check_refusal(load("pressure", "falloff = 1"), {"it only with type = \"attractors\""});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"pressure\"\nvalue = []\n",
                {"s.toml:14:9: found an empty list, expected a number, or [[t, value], …]"});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"pressure\"\nvalue = [1, 2]\n",
                {"s.toml:14:10: found 1, expected a list [[t, value], …] for 'value'"});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"pressure\"\nvalue = [[1, 2], [1, 3]]\n",
                {"s.toml:14:9: found a moment at 1 after one at 1, expected moments that ascend"});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"pressure\"\nvalue = [[1, 2], [2, nan]]\n",
                {"s.toml:14:22: found nan"});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"pressure\"\nvalue = [[1, 2], [2, 3]]\nmax = 2\n",
                {"s.toml:14:9: found 3, expected a value up to 2"});
}

TEST_CASE("errors in point clouds and attractors are reported with their position",
          "[io][scene][sculpt]") {
  check_refusal(load("point_cloud", ""), {"found no 'file' in [[load]]"});
  check_refusal(load("attractors", "at = [[0,0,0]]"),
                {"found attractors without a target", "one of: to, curve, plane"});
  check_refusal(load("attractors", "at = [[0,0,0]]\nto = [[0,0,1]]\ncurve = \"rim\""),
                {"found attractors with more than one target"});
  check_refusal(load("attractors", "at = [[0,0,0], [1,0,0]]\nto = [[0,0,1]]"),
                {"s.toml:16:6: found 1 points, expected 2, one for each point of 'at'"});
  check_refusal(load("attractors", "at = [0,0,0]\nto = [[0,0,1]]"),
                {"s.toml:15:7: found 0, expected a list of points"});
  check_refusal(load("attractors", "at = []\nto = []"),
                {"found an empty list, expected at least one point"});
  check_refusal(
      load("attractors", "at = [[0,0,0]]\nplane = { origin = [0,0,0], normal = [0,0,0] }"),
      {"s.toml:16:", "found [0, 0, 0], expected a direction"});
  check_refusal(load("attractors", "at = [[0,0,0]]\nto = [[0,0,1]]\nfalloff = -1"),
                {"s.toml:17:11: found -1, expected a length, not below 0"});
  check_refusal(
      load("point_cloud", "file = \"p.csv\"\nfalloff = 1"),
      {"s.toml:16:11: found 'falloff' for the load 'l'", "only with type = \"attractors\""});
  check_refusal(load("attractors", "file = \"p.csv\"\nat = [[0,0,0]]"),
                {"found 'file' for the load 'l'", "only with type = \"point_cloud\""});
  check_refusal(load("springs", "file = \"p.csv\""),
                {"gravity, point, line, point_cloud, attractors"});
  check_refusal("[[load]]\nname = \"l\"\ntype = \"point_cloud\"\nvalue = -1\nfile = \"p.csv\"\n",
                {"s.toml:14:9: found -1, expected a stiffness, not below 0"});
}

TEST_CASE("errors in stiffness fields, offsets and motion are reported with their position",
          "[io][scene][sculpt]") {
  const std::string weight = "[[stiffness]]\nname = \"w\"\nvalue = 1\n";
  check_refusal(weight, {"found no 'type' in [[stiffness]]"});
  check_refusal(weight + "type = \"gamma\"\n",
                {"s.toml:14:8: found the word 'gamma'", "expected one of: alpha, beta"});
  check_refusal(weight + "type = \"beta\"\nalong = \"spin\"\n",
                {"s.toml:15:9: found the curve 'spin'", "did you mean 'spine'?"});
  check_refusal(weight + "type = \"beta\"\nparametric_direction = [0, 0]\n",
                {"s.toml:15:24: found [0, 0]"});
  check_refusal(weight + "type = \"beta\"\nparametric_direction = [1, 0, 0]\n",
                {"[u, v] for 'parametric_direction'"});
  check_refusal("[[stiffness]]\nname = \"alpha\"\ntype = \"beta\"\nvalue = 1\n",
                {"s.toml:12:8: found the stiffness field name 'alpha'", "a parameter of [skin]"});
  const std::string move = "[[offset]]\nname = \"m\"\nvalue = 1\n";
  check_refusal(move, {"found no 'curve' in [[offset]]"});
  check_refusal(move + "curve = \"ribb\"\n", {"s.toml:14:9: found the curve 'ribb'"});
  check_refusal(move + "curve = \"spine\"\nfade = 0.6\n", {"s.toml:15:8: found 0.6", "0 to 0.5"});
  check_refusal(move + "curve = \"spine\"\ndirection = [0,0,0]\n", {"found [0, 0, 0]"});
  check_refusal(move + move + "curve = \"spine\"\n", {"found no 'curve'"});
  check_refusal(move + "curve = \"spine\"\n" + move + "curve = \"rim\"\n",
                {"s.toml:16:8: found the name 'm' again (first in line 12)"});
  check_refusal("[motion]\ndensity = -1\n", {"s.toml:12:11: found -1"});
  check_refusal("[motion]\ntheta = 0.4\n", {"s.toml:12:9: found 0.4, expected a number from 0.5"});
  check_refusal("[motion]\ndampng = 1\n", {"found key 'dampng' in [motion]", "'damping'?"});
  const std::string held = "[[constraint]]\nname = \"c\"\ntype = \"curve_normal\"\n";
  check_refusal(held, {"found no 'curve' in [[constraint]]"});
  check_refusal(held + "curve = \"spine\"\nat = [0,0,0]\n", {"s.toml:15:6: found 'at'", "'curve'"});
  check_refusal(held + "curve = \"sipne\"\n", {"s.toml:14:9: found the curve 'sipne'"});
  check_refusal(
      "[[constraint]]\nname = \"c\"\ntype = \"point\"\nat = [0,0,0]\nto = [0,0,1]\n"
      "curve = \"rim\"\n",
      {"s.toml:16:9", "it only with type = \"curve_normal\""});
}

TEST_CASE("errors in rules are reported with their position", "[io][scene][sculpt]") {
  const std::string slider = "[[parameter]]\nname = \"p\"\nvalue = 1\n";
  check_refusal(slider + "drives = [{ name = \"betta\", factor = 1 }]\n",
                {"s.toml:14:20: found 'betta' to drive, expected one of: p, alpha, beta",
                 "did you mean 'beta'?"});
  check_refusal(slider + "drives = [{ name = \"beta\" }]\n", {"s.toml:14:", "no 'factor'"});
  check_refusal(slider + "drives = [{ name = \"beta\", factr = 1 }]\n",
                {"s.toml:14:28: found key 'factr'", "did you mean 'factor'?"});
  check_refusal(slider + "drives = [{ name = \"p\", factor = 1 }]\n",
                {"s.toml:14:20: parameter 'p': found a circular dependency: 'p' depends on 'p'"});
  check_refusal(slider +
                    "drives = [{ name = \"q\", factor = 1 }]\n[[parameter]]\nname = \"q\"\n"
                    "value = 1\ndrives = [{ name = \"p\", factor = 1 }]\n",
                {"s.toml:18:20: parameter 'q': found a circular dependency: 'q' depends on 'p' "
                 "depends on 'q'"});
  check_refusal(
      slider + "drives = [{ name = \"beta\", factor = 1 }, { name = \"beta\", factor = 2 }]\n",
      {"found 'beta' again"});
  check_refusal(slider +
                    "drives = [{ name = \"beta\", factor = 1, offset = 1 }]\n[[parameter]]\n"
                    "name = \"q\"\nvalue = 1\n"
                    "drives = [{ name = \"beta\", factor = 1, offset = 2 }]\n",
                {"s.toml:18:20: found another offset of 'beta' (the first in line 14)"});
  check_refusal(slider +
                    "drives = [{ name = \"l\", factor = 1 }]\n[[load]]\nname = \"l\"\n"
                    "type = \"pressure\"\nvalue = [[0, 1], [1, 2]]\n",
                {"s.toml:14:20: found 'l' to drive, whose value is a function of time"});
  check_refusal(slider +
                    "drives = [{ name = \"fair-1.deviation\", factor = 1 }]\n[[fair]]\n"
                    "curves = [\"spine\"]\ndeviation = 0.1\n",
                {"which changes the curves"});
  check_refusal("[[parameter]]\nname = \"p\"\n", {"found no 'value'"});
}
