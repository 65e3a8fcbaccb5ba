// SPDX-License-Identifier: MPL-2.0
// Scenes of networks: their interpretation, and messages for errors.
#include "batten/io/scene/scene.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;

namespace {

const std::string kLine = R"(unit = "mm"
[[curve]]
name = "a"
points = [[0,0,0], [1,0,0], [1,1,0], [0,0,0]]
)";

std::string error_message_of(const std::string& rest) {
  return error_message([&] { parse_scene(kLine + rest, "s.toml"); });
}

void check_error(const std::string& rest, const std::vector<std::string>& parts) {
  const std::string message = error_message_of(rest);
  for (const auto& part : parts) {
    INFO("scene:\n" << rest << "\nmessage: " << message << "\nexpected in it: " << part);
    CHECK(message.find(part) != std::string::npos);
  }
}

}  // namespace

TEST_CASE("a scene with a network is read as it is written", "[io][scene][network]") {
  const Scene scene = parse_scene(kLine + R"(
[skin]
gap_tolerance = 0.5
tangent_angle = 8
max_faces_per_edge = 3
crease_angle = 30
angle_tolerance = 0.05
alpha = 0.1

[mesh]
edge_length = 2
[[face]]
name = "top"
loops = [["a", "b"], ["c"]]
inner = ["d"]
[[face]]
loops = [["e"]]
surface = false
[[face]]
name = "tube"
loops = [["a"], ["c"]]
annulus = true
[[join]]
curves = ["a", "b"]
continuity = "smooth"
[[join]]
curves = ["c"]
continuity = "G0"
[[picture]]
file = "p.png"
show = "faces"
)",
                                  "s.toml");
  const SceneNetwork& n = scene.network;
  CHECK(n.tolerance == 0.5);
  CHECK(n.tangent_angle == 8);
  CHECK(n.max_faces_per_edge == 3);
  CHECK(n.crease_angle == 30);
  CHECK(n.join_tolerance == 0.05);
  REQUIRE(n.regions.size() == 3);
  CHECK(n.regions[0].name == "top");
  CHECK(n.regions[0].loops == std::vector<std::vector<std::string>>{{"a", "b"}, {"c"}});
  CHECK(n.regions[0].inner == std::vector<std::string>{"d"});
  CHECK(n.regions[0].kind == RegionSpec::Kind::Surface);
  CHECK(n.regions[0].where == "s.toml:18:9: ");
  CHECK(n.regions[1].kind == RegionSpec::Kind::NoSurface);
  CHECK(n.regions[2].annulus);
  REQUIRE(n.joins.size() == 3);
  CHECK(n.joins[1].line == "b");
  CHECK(n.joins[1].kind == JoinSpec::Kind::Smooth);
  CHECK(n.joins[1].where == "s.toml:28:16: ");
  CHECK(n.joins[2].kind == JoinSpec::Kind::Crease);
  CHECK(scene.pictures[0].look.field == PictureScene::Field::Regions);
  CHECK(scene.skin.options.edge_length == 2);
}

TEST_CASE("a scene without settings has the kernel's defaults", "[io][scene][network]") {
  const Scene scene = parse_scene(kLine, "s.toml");
  CHECK(scene.network.tolerance == 0);
  CHECK(scene.network.tangent_angle == NetworkOptions{}.tangent_angle);
  CHECK(scene.network.crease_angle == ModelOptions{}.crease_angle_deg);
  CHECK(scene.network.join_tolerance == ModelOptions{}.join_tolerance_deg);
  CHECK(scene.network.max_faces_per_edge == RegionSearchOptions{}.max_faces_per_edge);
}

TEST_CASE("G1 equals smooth if nothing is faired, G2 needs fairing", "[io][scene][network]") {
  const auto kind = [](const std::string& rest) {
    return parse_scene(kLine + rest, "s.toml").network.joins.at(0).kind;
  };
  const std::string join = "[[join]]\ncurves = [\"a\"]\ncontinuity = ",
                    fair = "[skin]\nfair = \"variation\"\n";
  CHECK(kind(join + "\"G1\"\n") == JoinSpec::Kind::Smooth);
  CHECK(kind(join + "\"G1\"\n" + fair) == JoinSpec::Kind::Tangent);
  CHECK(kind(join + "\"G2\"\n" + fair) == JoinSpec::Kind::Curvature);
  check_error(join + "\"G2\"\n", {"s.toml:7:14:", "\"G2\" for a surface that is not faired"});
}

TEST_CASE("settings that several faces exclude are refused with the reason",
          "[io][scene][network]") {
  const std::string n = "[[join]]\ncurves = [\"a\"]\ncontinuity = \"G0\"\n";
  check_error(n + "[mesh]\ndomain = \"annulus\"\n",
              {"s.toml:9:10:", "'domain' beside [[face]] or [[join]]", "each"});
  check_error(n + "[mesh]\nrefine = 2\n", {"'refine'", "edge_length"});
  check_error(n + "[skin]\nalpha = [1, 0, 1]\n", {"s.toml:9:9:", "three numbers", "one number"});
}

TEST_CASE("everything that acts on a surface acts on a network", "[io][scene][network]") {
  const Scene scene = parse_scene(kLine + R"(
[skin]
boundary = "corners"
load_units = "absolute"
[[load]]
name = "l"
type = "pressure"
value = 1
faces = ["top"]
[[parameter]]
name = "p"
value = 1
[[sweep]]
file = "a.png"
parameter = "l"
values = [1]
[stress]
thickness = 1
young = 1
pressures = [{face = "top", pressure = 2}]
supports = [{curve = "a"}]
[output]
step = "a.step"
step_form = "exact"
calculix = "a.inp"
)",
                                  "s.toml");
  CHECK(scene.is_sculpted());
  CHECK(scene.loads[0].area.regions[0].text == "top");
  CHECK(scene.skin.boundary == SceneSkin::FixedBoundary::Corners);
  CHECK(scene.step_form == Scene::StepForm::Exact);
  CHECK(scene.stress->loads[0].region.text == "top");
}

TEST_CASE("settings of faces and joins are checked at their position", "[io][scene][network]") {
  const std::string n = "\n";
  check_error(n + "[[face]]\nname = \"r\"\n", {"loops"});
  check_error(n + "[[face]]\nloops = []\n", {"s.toml:7:9:", "an empty list"});
  check_error(n + "[[face]]\nloops = [\"a\"]\n", {"s.toml:7:10:", "list of lists of names"});
  check_error(n + "[[face]]\nloops = [[\"a\"], []]\n", {"s.toml:7:17:", "an empty list"});
  check_error(n + "[[face]]\nloops = [[\"a\"]]\nannulus = true\n",
              {"s.toml:8:11:", "annulus = true with 1 loops", "2"});
  check_error(n + "[[face]]\nloops = [[\"a\"]]\nsurface = false\nname = \"x\"\n", {"'name'"});
  check_error(n + "[[face]]\nloops = [[\"a\"], [\"b\"]]\nsurface = false\n", {"2 loops", "one"});
  check_error(n + "[[face]]\nname=\"x\"\nloops=[[\"a\"]]\n[[face]]\nname=\"x\"\nloops=[[\"b\"]]\n",
              {"s.toml:10:6:", "the face name 'x' again"});
  check_error(n + "[[join]]\ncurves = [\"a\"]\ncontinuity = \"smoth\"\n",
              {"s.toml:8:14:", "'smoth'", "did you mean 'smooth'?"});
  check_error(n + "[[join]]\ncontinuity = \"smooth\"\n", {"curves"});
  check_error("[skin]\ngap_tolerence = 1\n", {"s.toml:6:1:", "did you mean 'gap_tolerance'?"});
  check_error("[skin]\ngap_tolerance = -1\n", {"s.toml:6:17:"});
  check_error("[skin]\ntangent_angle = 60\n", {"s.toml:6:17:", "0 to 45"});
  check_error("[skin]\nmax_faces_per_edge = 0\n", {"s.toml:6:"});
  check_error("[skin]\nmax_faces_per_edge = 99\n", {"1 to 16"});
}
