// Scenes that people typed from the documentation alone come out as they meant them.
#include <regex>

#include "batten/tests/apps/cli_case.h"

using namespace batten_test;

namespace {

struct Newcomer {
  Result ran;
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

// The scene without its pictures, changed.
template <class Change>
Newcomer run(const std::string& name, const Change& change) {
  const fs::path file = optional_data("newcomer-scenes") / name;
  std::string scene = contents(file);
  for (const char* section : {"picture", "sweep"}) scene = without(scene, section);
  const Case c("newcomer");
  c.file("s.toml", change(scene));
  Newcomer result{c.run({"run", "s.toml", "--out", "out"}), {}};
  if (fs::exists(c / "out/report.json"))
    result.report = nlohmann::json::parse(contents(c / "out/report.json"));
  return result;
}
Newcomer run(const std::string& name) {
  return run(name, [](const std::string& scene) { return scene; });
}

bool there() {
  if (BATTEN_TEST_CGAL && !optional_data("newcomer-scenes").empty()) return true;
  WARN("skipped: newcomer-scenes is not there (set BATTEN_TEST_DATA), or CGAL");
  return false;
}

}  // namespace

TEST_CASE("what newcomers typed is made, and every promise held", "[cli][newcomers]") {
  if (!there()) return;
  for (const char* name :
       {"01-fender/scene.toml", "03-guitar/scene.toml", "05-bottle/scene.toml",
        "06-chair/scene.toml", "07-deck/noholes.toml", "07-deck/pieces.toml", "small/lid6.toml"}) {
    const Newcomer n = run(name);
    INFO(name << n.ran.err);
    CHECK(n.ran.code == 0);
    REQUIRE(n.report.contains("step"));
    CHECK(n.report["step"]["form"] == "face");
    CHECK(n.report["step"]["valid"] == true);
  }
}

TEST_CASE("a deck's centre line is cut where hatches take it, and moves as one",
          "[cli][newcomers]") {
  if (!there()) return;
  const Newcomer n = run("07-deck/scene.toml");
  INFO(n.ran.err);
  CHECK(n.ran.code == 0);
  int pieces = 0;
  for (const auto& line : n.report["lines"]["each"])
    pieces += line["name"].get<std::string>().starts_with("centreline.");
  CHECK(pieces == 4);
  const Newcomer moved = run("07-deck/scene.toml", [](const std::string& scene) {
    return std::regex_replace(scene, std::regex("value = 0"), "value = 40");
  });
  INFO(moved.ran.err);
  CHECK(moved.ran.code == 0);
  CHECK(moved.report["surface"]["moved"] == Approx(40).epsilon(0.05));
}

TEST_CASE("a mast that misses the centre line is named with place and distance",
          "[cli][newcomers]") {
  if (!there()) return;
  const Newcomer n = run("07-deck/scene.toml", [](const std::string& scene) {
    const std::string text = without(scene, "move");
    const size_t mast = text.find("\"mast\""), end = text.find("role", mast);
    // Flattened: all its points at one height.
    return text.substr(0, mast) +
           std::regex_replace(text.substr(mast, end - mast),
                              std::regex(R"(, (10[0-9]+\.[0-9]+)\])"), ", 1060]") +
           text.substr(end);
  });
  CHECK(n.ran.code == 1);
  CHECK(std::regex_search(n.ran.err, std::regex("'centreline' passes the hole's line 'mast' at a "
                                                "distance of [2-7]\\.?[0-9]* near \\(5")));
}

TEST_CASE("pickups that only trim let the arch rise", "[cli][newcomers]") {
  if (!there()) return;
  const Newcomer held = run("03-guitar/scene.toml");
  const Newcomer free = run("03-guitar/scene.toml", [](const std::string& scene) {
    return std::regex_replace(scene, std::regex("role *= *\"hole\""),
                              "role = \"hole\"\nhold = false");
  });
  INFO(free.ran.err);
  CHECK(free.ran.code == 0);
  CHECK(free.report["surface"]["moved"] > 1.5 * held.report["surface"]["moved"].get<double>());
  CHECK(free.ran.out.find("trimmed     by 'neck pickup.1', drawn within ") != std::string::npos);
}

TEST_CASE("a can is a cylinder where it is asked to be fair", "[cli][newcomers]") {
  if (!there()) return;
  const Newcomer n = run("small/can.toml", [](const std::string& scene) {
    return std::regex_replace(scene, std::regex("\\[skin\\]"), "[skin]\nfair = \"variation\"");
  });
  INFO(n.ran.err);
  CHECK(n.ran.code == 0);
  const double exact = 3.14159265358979 * 20 * 20 * 40;
  CHECK(std::abs(n.report["step"]["volume"].get<double>() / exact - 1) < 5e-3);
}
