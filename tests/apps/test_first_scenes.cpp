// SPDX-License-Identifier: MPL-2.0
// Scenes written by new users from the documentation alone give the intended results.
#include <cstdlib>
#include <map>
#include <regex>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

struct FirstScene {
  CliResult ran;
  nlohmann::json report;
};

std::string without(const std::string& scene, const std::string& section) {
  std::string text = scene;
  for (size_t at; (at = text.find("[" + section + "]")) != text.npos;) {
    const size_t begin = text[at - 1] == '[' ? at - 1 : at, next = text.find("\n[", at);
    text.erase(begin, next == text.npos ? text.npos : next + 1 - begin);
  }
  return text;
}

// The scene without pictures, with present keys, and with changes.
template <class Change>
FirstScene run(const std::string& name, const Change& change) {
  const fs::path file = optional_data("newcomer-scenes") / name;
  std::string scene = contents(file);
  for (const char* section : {"picture", "sweep"}) scene = without(scene, section);
  const CliCase c("newcomer");
  c.file("s.toml", scene);
  REQUIRE(std::system(("python3 '" BATTEN_SOURCE_DIR "/tests/support/update_scene.py' '" +
                       (c / "s.toml").string() + "'")
                          .c_str()) == 0);
  c.file("s.toml", change(contents(c / "s.toml")));
  FirstScene result{c.run({"run", "s.toml", "--out", "out"}), {}};
  if (fs::exists(c / "out/report.json"))
    result.report = nlohmann::json::parse(contents(c / "out/report.json"));
  return result;
}
FirstScene run(const std::string& name) {
  return run(name, [](const std::string& scene) { return scene; });
}

bool data_available() {
  if (BATTEN_TEST_CGAL && !optional_data("newcomer-scenes").empty()) return true;
  WARN("skipped: newcomer-scenes is not there (set BATTEN_TEST_DATA), or CGAL");
  return false;
}

}  // namespace

TEST_CASE("scenes as new users write them are made, and pass all checks", "[apps][first_scenes]") {
  if (!data_available()) return;
  for (const char* name :
       {"01-fender/scene.toml", "01-fender/flange.toml", "01-fender/flange_load.toml",
        "01-fender/flange_move.toml", "01-fender/flange_stress.toml", "03-guitar/scene.toml",
        "05-bottle/scene.toml", "06-chair/scene.toml", "07-deck/noholes.toml",
        "07-deck/pieces.toml", "09-propeller/scene.toml", "09-propeller/all.toml",
        "small/lid6.toml"}) {
    const FirstScene n = run(name);
    INFO(name << n.ran.err);
    CHECK(n.ran.code == 0);
    REQUIRE(n.report.contains("step"));
    CHECK(n.report["step"]["form"] == "face");
    CHECK(n.report["step"]["valid"] == true);
  }
}

TEST_CASE("a deck's centre line is cut at hatches, and moves as one curve",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  const FirstScene n = run("07-deck/scene.toml");
  INFO(n.ran.err);
  CHECK(n.ran.code == 0);
  int pieces = 0;
  for (const auto& line : n.report["curves"]["each"])
    pieces += line["name"].get<std::string>().starts_with("centreline.");
  CHECK(pieces == 4);
  const FirstScene moved = run("07-deck/scene.toml", [](const std::string& scene) {
    return std::regex_replace(scene, std::regex("value = 0"), "value = 40");
  });
  INFO(moved.ran.err);
  CHECK(moved.ran.code == 0);
  CHECK(moved.report["surface"]["max_displacement"] == Approx(40).epsilon(0.05));
}

TEST_CASE("a mast that misses the centre line is named with position and distance",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  const FirstScene n = run("07-deck/scene.toml", [](const std::string& scene) {
    const std::string text = without(scene, "offset");
    const size_t mast = text.find("\"mast\""), end = text.find("role", mast);
    // Flattened: all its points at the same height.
    return text.substr(0, mast) +
           std::regex_replace(text.substr(mast, end - mast),
                              std::regex(R"(, (10[0-9]+\.[0-9]+)\])"), ", 1060]") +
           text.substr(end);
  });
  CHECK(n.ran.code == 1);
  CHECK(std::regex_search(n.ran.err, std::regex("'centreline' passes curve 'mast' of a hole at a "
                                                "distance of [2-7]\\.?[0-9]* near \\(5")));
}

TEST_CASE("pickups that only trim let the arch rise", "[apps][first_scenes]") {
  if (!data_available()) return;
  const FirstScene held = run("03-guitar/scene.toml");
  const FirstScene free = run("03-guitar/scene.toml", [](const std::string& scene) {
    return std::regex_replace(scene, std::regex("role *= *\"hole\""),
                              "role = \"hole\"\ntrim_only = true");
  });
  INFO(free.ran.err);
  CHECK(free.ran.code == 0);
  CHECK(free.report["surface"]["max_displacement"] >
        1.5 * held.report["surface"]["max_displacement"].get<double>());
  CHECK(free.ran.out.find("trimmed     by 'neck pickup.1', at most ") != std::string::npos);
}

TEST_CASE("a can is a cylinder, faired or not, unless it is asked to bend",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  const auto can = [](const std::string& skin) {
    return run("small/can.toml", [&](const std::string& scene) { return scene + "\n" + skin; });
  };
  for (const char* fair : {"", "[skin]\nfair = \"variation\"\n"}) {
    const FirstScene n = can(fair);
    INFO(n.ran.err);
    CHECK(n.ran.code == 0);
    const double exact = 3.14159265358979 * 20 * 20 * 40;
    CHECK(std::abs(n.report["step"]["volume"].get<double>() / exact - 1) < 1e-3);
  }
  const FirstScene bent = can("[skin]\nfair = \"bending\"\n");
  CHECK(bent.report["step"]["volume"].get<double>() < 0.9 * 3.14159265358979 * 20 * 20 * 40);
}

TEST_CASE("a propeller is a solid of skins, a bottle has the recess it was given",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  const FirstScene blade = run("09-propeller/scene.toml");
  CHECK(blade.report["faces"].size() == 13);
  CHECK(blade.report["left_over"]["unused_edges"].empty());
  CHECK(blade.report["step"]["solids"] == 1);
  const FirstScene bottle = run("05-bottle/scene.toml");
  int recess = 0, bands = 0;
  for (const auto& region : bottle.report["faces"]) {
    recess += region.value("shape", "") == "cylinder" &&
              std::abs(region.value("radius", 0.0) - 33.8) < 0.02;
    bands += region.value("shape", "") == "cone";
  }
  CHECK(recess == 2);
  CHECK(bands == 4);
}

TEST_CASE("a normal that no surface through a curve can have is refused with the reason",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  const FirstScene n = run("01-fender/flange_constraint.toml");
  CHECK(n.ran.code == 1);
  CHECK(n.ran.err.find(
            "'flat at hood' prescribes a normal that is not perpendicular to curve 'hood line'") !=
        std::string::npos);
}

TEST_CASE("solids that new users drew curve by curve have the intended volume",
          "[apps][first_scenes]") {
  if (!data_available()) return;
  constexpr double pi = 3.14159265358979;
  struct Solid {
    const char* name;
    size_t faces;
    double volume;  // 0: open
    std::map<std::string, int> shapes;
  };
  const Solid solids[] = {
      {"torus2", 8, 2 * pi * pi * 100 * 30 * 30, {{"torus", 8}}},
      {"boxround", 6, 0, {{"plane", 5}, {"cylinder", 1}}},
      {"boxfillet", 10, (6000 - (4 - pi) * 100) * 40, {{"plane", 6}, {"cylinder", 4}}},
      {"dshape", 6, (70 * 60 + pi * 900 / 2) * 40, {{"plane", 5}, {"cylinder", 1}}},
      {"boxhole", 8, 240'000 - pi * 144 * 40, {{"plane", 6}, {"cylinder", 2}}},
      {"cylinder", 4, 0, {{"cylinder", 4}}}};
  for (const Solid& solid : solids) {
    INFO(solid.name);
    const fs::path file =
        optional_data("newcomer-scenes") / "networks" / (std::string(solid.name) + ".csv");
    const CliCase c("newcomer");
    const CliResult ran = c.run({"skin", file.string(), "--unit", "mm", "--out", "out"});
    INFO(ran.err);
    CHECK(ran.code == 0);
    const auto report = nlohmann::json::parse(contents(c / "out/report.json"));
    CHECK(report["faces"].size() == solid.faces);
    std::map<std::string, int> shapes;
    for (const auto& region : report["faces"]) ++shapes[region.value("shape", "")];
    CHECK(shapes == solid.shapes);
    CHECK(report["step"]["faces"] == solid.faces);
    if (solid.volume > 0) {
      CHECK(report["step"]["solids"] == 1);
      CHECK(std::abs(report["step"]["volume"].get<double>() / solid.volume - 1) < 2e-3);
    }
  }
}
