// SPDX-License-Identifier: MPL-2.0
// Edits of a scene's text: the edited values change, and no other character.
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_text.h"
#include "batten/tests/support/catch.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

using namespace batten;

namespace {

const std::string kScene = R"(# A panel with an ü.
unit = "mm"   # as drawn
name = "pänel"

[[curve]]
name = "rim"
points = [ # in any direction
  [0,0,0], [1,0,0],   # front
  [1,1,0], [0,0,0],
]

# The skin.
[skin]
alpha = 0     # no stretching
beta = [1, 2, 3]

# It swells.
[[load]]
name = "swell"
type = "pressure"
value = 3.0   # try 5
paint = [{ at = [1, 2, 3], radius = 2 }]

[[constraint]]
name = "pin"
type = "point"
at = [0.5, 0.5, 0]
to = [0.5, 0.5, 1]
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a table that ends with a list of several lines is removed completely", "[io][scene]") {
  const std::string before = "unit = \"mm\"\n\n[skin]\nbeta = 2\n";
  SceneText scene(
      before +
      "\n[stress]\nthickness = 1\nsupports = [\n  { curve = \"a\" },\n  { curve = \"b\" "
      "},\n]\n");
  scene.remove({"stress", ""});
  CHECK(scene.text() == before);
}

TEST_CASE("a value in a scene's text is replaced and nothing else", "[io][scene]") {
  SceneText scene(kScene, "s.toml");
  scene.set({"load", "swell"}, "value", "5");
  CHECK(scene.text() == replaced(kScene, "value = 3.0 ", "value = 5 "));
  scene = SceneText(kScene);
  scene.set({}, "name", "\"x\"");
  CHECK(scene.text() == replaced(kScene, "\"pänel\"", "\"x\""));
  scene = SceneText(kScene);
  scene.set({"curve", "rim"}, "points", "[[0, 0, 0], [2, 0, 0]]");
  CHECK(scene.value({"curve", "rim"}, "points") == "[[0, 0, 0], [2, 0, 0]]");
  CHECK(scene.text().ends_with(kScene.substr(kScene.find("\n\n# The skin."))));
  scene = SceneText(kScene);
  scene.set_item({"constraint", "pin"}, "to", 2, "-4.5");
  CHECK(scene.text() == replaced(kScene, "to = [0.5, 0.5, 1]", "to = [0.5, 0.5, -4.5]"));
}

TEST_CASE("a key is added behind the last of its table, and taken out again", "[io][scene]") {
  const std::vector<SceneTable> tables = {
      {}, {"skin", ""}, {"load", "swell"}, {"curve", "rim"}, {"constraint", "pin"}};
  for (const SceneTable& table : tables) {
    SceneText scene(kScene);
    scene.set(table, "extra", "[1, 2]");
    CHECK(scene.value(table, "extra") == "[1, 2]");
    CHECK(scene.text() != kScene);
    scene.erase(table, "extra");
    CHECK(scene.text() == kScene);
  }
  SceneText scene(kScene);
  scene.set({"motion", ""}, "density", "0.5");
  CHECK(scene.text() == kScene + "\n[motion]\ndensity = 0.5\n");
}

TEST_CASE("a table is added behind its kind, and removed with its comment", "[io][scene]") {
  SceneText scene(kScene);
  const SceneTable added =
      scene.add("load", "{ name = \"push\", type = \"point\", at = [1, 2, 3], value = -1e-3 }");
  CHECK(added == SceneTable{"load", "push"});
  CHECK(scene.text() ==
        replaced(kScene, "radius = 2 }]\n",
                 "radius = 2 }]\n\n[[load]]\nname = \"push\"\ntype = \"point\"\nat = [1, 2, 3]\n"
                 "value = -1e-3\n"));
  scene.remove(added);
  CHECK(scene.text() == kScene);
  scene.remove({"load", "swell"});
  CHECK(scene.text().find("swells") == std::string::npos);
  CHECK(scene.text().find("# The skin.") != std::string::npos);
  CHECK_FALSE(scene.has({"load", "swell"}));
  scene.remove({"constraint", "pin"});
  CHECK(scene.text().ends_with("beta = [1, 2, 3]\n"));
  CHECK(scene.add("join", "{ curves = [\"rim\"], continuity = \"G0\" }") ==
        SceneTable{"join", "#1"});
}

TEST_CASE("a parameter's value reads back with the same bits", "[io][scene]") {
  for (const double value : {0.1, -1.0 / 3, 5e-324, 1.7976931348623157e308, 123456789.123456789}) {
    SceneText scene(kScene);
    scene.set_parameter("swell", value);
    const Scene read = parse_scene(scene.text(), "s.toml");
    CHECK(read.loads.front().value == value);
  }
  SceneText scene(kScene);
  scene.set_parameter("pin.z", 7);
  scene.set_parameter("alpha", 0.25);
  scene.set_parameter("beta_uv", 9);
  const Scene read = parse_scene(scene.text(), "s.toml");
  CHECK(read.constraints.front().goal.z() == 7);
  CHECK(read.skin.material.alpha(0, 0) == 0.25);
  CHECK(read.skin.material.beta[1] == 9);
  CHECK_THROWS_AS(scene.set_parameter("swel", 1), InputError);
  CHECK_THROWS_AS(SceneText::toml_value(std::numeric_limits<double>::quiet_NaN()), InputError);
}

TEST_CASE("tables in braces are edited in place", "[io][scene]") {
  const std::string braces =
      "unit = \"mm\"\nload = [{ name = \"a\", value = 1 }, { name = \"b\" }]\n";
  SceneText scene(braces);
  scene.set({"load", "a"}, "value", "2");
  scene.set({"load", "b"}, "value", "3");
  CHECK(scene.text() ==
        "unit = \"mm\"\nload = [{ name = \"a\", value = 2 }, { name = \"b\", value = 3 }]\n");
  scene.erase({"load", "a"}, "value");
  CHECK(scene.value({"load", "a"}, "value").empty());
  CHECK(scene.value({"load", "b"}, "value") == "3");
  CHECK_THROWS_AS(scene.remove({"load", "a"}), InputError);
}

TEST_CASE("an edit that is refused leaves the text as it was", "[io][scene]") {
  SceneText scene(kScene);
  CHECK_THROWS_AS(scene.set({"load", "swell"}, "value", "1\nother = 2"), InputError);
  CHECK_THROWS_AS(scene.set({"load", "swell"}, "value", "[1, 2"), InputError);
  CHECK_THROWS_AS(scene.set({"load", "swel"}, "value", "1"), InputError);
  CHECK_THROWS_AS(scene.set({"load", "swell"}, "a b", "1"), InputError);
  CHECK_THROWS_AS(scene.add("load", "{ name = 1 }\n[skin]"), InputError);
  CHECK_THROWS_AS(scene.add("load", "3"), InputError);
  CHECK_THROWS_AS(scene.erase({"skin", ""}, "gamma"), InputError);
  CHECK_THROWS_AS(scene.set_item({"skin", ""}, "beta", 3, "1"), InputError);
  CHECK(scene.text() == kScene);
  CHECK_THROWS_AS(SceneText("a = [", "s.toml"), InputError);
}

TEST_CASE("line ends, byte-order marks and missing last line ends are kept", "[io][scene]") {
  std::string windows;
  for (const char c : kScene) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  SceneText scene("\xEF\xBB\xBF" + windows);
  scene.set({"skin", ""}, "gap_tolerance", "4");
  CHECK(std::count(scene.text().begin(), scene.text().end(), '\n') ==
        std::count(scene.text().begin(), scene.text().end(), '\r'));
  scene.set({}, "unit", "\"cm\"");
  CHECK(scene.text().starts_with("\xEF\xBB\xBF# A panel"));
  scene.erase({"skin", ""}, "gap_tolerance");
  scene.set({}, "unit", "\"mm\"");
  CHECK(scene.text() == "\xEF\xBB\xBF" + windows);
  SceneText open("unit = \"mm\"");
  open.set({}, "name", "\"x\"");
  open.add("load", "{ name = \"a\" }");
  CHECK(open.text() == "unit = \"mm\"\nname = \"x\"\n\n[[load]]\nname = \"a\"\n");
}

TEST_CASE("the parts of a scene distinguish values, loads and the model", "[io][scene]") {
  const auto changed = [](const auto& edit) {
    SceneText scene(kScene);
    edit(scene);
    return scene_dependencies(scene);
  };
  const SceneDependencies before = scene_dependencies(SceneText(kScene));
  const SceneDependencies value = changed([](SceneText& s) { s.set_parameter("swell", 9); });
  CHECK(value.model == before.model);
  CHECK(value.session_parts == before.session_parts);
  const SceneDependencies goal = changed([](SceneText& s) { s.set_parameter("pin.x", 9); });
  CHECK(goal.session_parts == before.session_parts);
  const SceneDependencies type = changed([](SceneText& s) {
    s.set({"load", "swell"}, "type", "\"gravity\"");
  });
  CHECK(type.model == before.model);
  CHECK(type.session_parts != before.session_parts);
  const SceneDependencies line = changed([](SceneText& s) {
    s.set_item({"curve", "rim"}, "points", 0, "[0, 0, 5]");
  });
  CHECK(line.model != before.model);
  CHECK(line.session_parts == before.session_parts);
  const SceneDependencies output = changed([](SceneText& s) {
    s.set({"output", ""}, "step", "\"a.step\"");
  });
  CHECK(output.model == before.model);
  CHECK(output.session_parts == before.session_parts);
}

TEST_CASE("every example can be edited and comes back as it was", "[io][scene]") {
  namespace fs = std::filesystem;
  int scenes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(BATTEN_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".toml") continue;
    ++scenes;
    std::ostringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    SceneText scene(text.str(), entry.path());
    for (const SceneTable& table : std::vector<SceneTable>(scene.tables())) {
      scene.set(table, "extra_key", "1");
      scene.erase(table, "extra_key");
      for (const auto& [key, value] : scene.values(table)) {
        if (key == "name") continue;  // another name denotes another table
        CHECK(value == scene.value(table, key));
        scene.set(table, key, "0");
        scene.set(table, key, value);
      }
    }
    INFO(entry.path());
    CHECK(scene.text() == text.str());
  }
  CHECK(scenes > 40);
}

TEST_CASE("tables of a list in a table have both names, and are changed where they are",
          "[io][scene]") {
  const std::string edits = R"(mesh = "a.obj"
[[edit]]
name = "first"
fixed = "left"
[[edit.handle]]   # the end
name = "right"
translate = [0, 0, 1]

[[edit]]
name = "second"

[output]
mesh = "b.obj"
)";
  SceneText scene(edits);
  CHECK(scene.has({"edit.handle", "first.right"}));
  CHECK(scene.values({"edit", "first"}) ==
        std::vector<SceneText::Value>{{"name", "\"first\""}, {"fixed", "\"left\""}});
  scene.set_parameter("first.right.y", 2.5);
  CHECK(scene.text() == replaced(edits, "[0, 0, 1]", "[0, 2.5, 1]"));
  scene.set_parameter("first.right.rotation.y", -30);
  CHECK(scene.value({"edit.handle", "first.right"}, "rotate") ==
        "{ axis = [0, -1, 0], angle = 30 }");
  scene.set_parameter("first.right.angle", 12);
  CHECK(scene.value({"edit.handle", "first.right"}, "rotate") ==
        "{ axis = [0, -1, 0], angle = 12 }");
  // A new one is part of the last edit, before the text that follows it.
  SceneText more(edits);
  CHECK(more.add("edit.handle", R"({ name = "nose" })") ==
        SceneTable{"edit.handle", "second.nose"});
  CHECK(more.text().find("nose") < more.text().find("[output]"));
  more.set_parameter("second.nose.scale", 1.2);
  CHECK(more.value({"edit.handle", "second.nose"}, "scale") == "1.2");
  more.remove({"edit.handle", "second.nose"});
  CHECK(more.text() == edits);
}
