// Scenes of networks: what they mean, and how mistakes are answered.
#include "batten/io/scene/read_scene.h"
#include "batten/io/scene/scene.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;

namespace {

const std::string kLine = R"(unit = "mm"
[[line]]
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

TEST_CASE("a scene with a network is read as it is written", "[scene][network]") {
  const Scene scene = parse_scene(kLine + R"(
[skin]
gap_tolerance = 0.5
straight_angle = 8
most_at_line = 3
crease_angle = 30
join_tolerance = 0.05
edge_length = 2
alpha = 0.1
[[region]]
name = "top"
loops = [["a", "b"], ["c"]]
inner = ["d"]
[[region]]
loops = [["e"]]
surface = false
[[region]]
name = "tube"
loops = [["a"], ["c"]]
ring = true
[[join]]
lines = ["a", "b"]
kind = "smooth"
[[join]]
lines = ["c"]
kind = "crease"
[[picture]]
file = "p.png"
show = "regions"
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
  CHECK(n.regions[0].where == "s.toml:16:9: ");
  CHECK(n.regions[1].kind == RegionSpec::Kind::NoSurface);
  CHECK(n.regions[2].annulus);
  REQUIRE(n.joins.size() == 3);
  CHECK(n.joins[1].line == "b");
  CHECK(n.joins[1].kind == JoinSpec::Kind::Smooth);
  CHECK(n.joins[1].where == "s.toml:26:15: ");
  CHECK(n.joins[2].kind == JoinSpec::Kind::Crease);
  CHECK(scene.pictures[0].look.field == PictureScene::Field::Regions);
  CHECK(scene.skin.options.edge_length == 2);
}

TEST_CASE("a scene without words has the kernel's defaults", "[scene][network]") {
  const Scene scene = parse_scene(kLine, "s.toml");
  CHECK(scene.network.tolerance == 0);
  CHECK(scene.network.tangent_angle == NetworkOptions{}.tangent_angle);
  CHECK(scene.network.crease_angle == ModelOptions{}.crease_angle_deg);
  CHECK(scene.network.join_tolerance == ModelOptions{}.join_tolerance_deg);
  CHECK(scene.network.max_faces_per_edge == RegionSearchOptions{}.max_faces_per_edge);
}

TEST_CASE("the table of older scenes is answered with what to write", "[scene][network]") {
  const Scene scene =
      parse_scene(kLine + "[network]\ntolerance = 0.5\nsymmetry = \"x\"\n", "s.toml");
  CHECK(scene.network.tolerance == 0.5);
  CHECK(scene.network.symmetry == 0);
  REQUIRE(scene.notes.size() == 1);
  for (const char* part :
       {"s.toml:5:1:", "delete it", "'tolerance' as gap_tolerance, 'symmetry' in [skin]"})
    CHECK(scene.notes[0].find(part) != std::string::npos);
}

TEST_CASE("what does not go with several regions is refused with the reason", "[scene][network]") {
  const std::string n = "[[join]]\nlines = [\"a\"]\nkind = \"crease\"\n";
  check_error(n + "[skin]\ndomain = \"ring\"\n",
              {"s.toml:9:10:", "'domain' beside [[region]] or [[join]]", "each"});
  check_error(n + "[skin]\nrefine = 2\n", {"'refine'", "edge_length"});
  check_error(n + "[skin]\nalpha = [1, 0, 1]\n", {"s.toml:9:9:", "three numbers", "one number"});
}

TEST_CASE("everything that acts on a surface acts on a network", "[scene][network]") {
  const Scene scene = parse_scene(kLine + R"(
[skin]
hold = "corners"
units = "absolute"
[[load]]
name = "l"
type = "pressure"
value = 1
regions = ["top"]
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
pressures = [{region = "top", pressure = 2}]
supports = [{line = "a"}]
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

TEST_CASE("words about regions and joins are checked where they stand", "[scene][network]") {
  const std::string n = "\n";
  check_error(n + "[[region]]\nname = \"r\"\n", {"loops"});
  check_error(n + "[[region]]\nloops = []\n", {"s.toml:7:9:", "an empty list"});
  check_error(n + "[[region]]\nloops = [\"a\"]\n", {"s.toml:7:10:", "list of lists of names"});
  check_error(n + "[[region]]\nloops = [[\"a\"], []]\n", {"s.toml:7:17:", "an empty list"});
  check_error(n + "[[region]]\nloops = [[\"a\"]]\nring = true\n",
              {"s.toml:8:8:", "ring = true with 1 loops", "2"});
  check_error(n + "[[region]]\nloops = [[\"a\"]]\nsurface = false\nname = \"x\"\n", {"'name'"});
  check_error(n + "[[region]]\nloops = [[\"a\"], [\"b\"]]\nsurface = false\n", {"2 loops", "one"});
  check_error(
      n + "[[region]]\nname=\"x\"\nloops=[[\"a\"]]\n[[region]]\nname=\"x\"\nloops=[[\"b\"]]\n",
      {"s.toml:10:6:", "the region name 'x' again"});
  check_error(n + "[[join]]\nlines = [\"a\"]\nkind = \"smoth\"\n",
              {"s.toml:8:8:", "'smoth'", "did you mean 'smooth'?"});
  check_error(n + "[[join]]\nkind = \"smooth\"\n", {"lines"});
  check_error("[skin]\ngap_tolerence = 1\n", {"s.toml:6:1:", "did you mean 'gap_tolerance'?"});
  check_error("[skin]\ngap_tolerance = -1\n", {"s.toml:6:17:"});
  check_error("[skin]\nstraight_angle = 60\n", {"s.toml:6:18:", "0 to 45"});
  check_error("[skin]\nmost_at_line = 0\n", {"s.toml:6:"});
  check_error("[skin]\nmost_at_line = 99\n", {"1 to 16"});
}
