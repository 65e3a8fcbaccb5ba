// SPDX-License-Identifier: MPL-2.0
// The examples of batten deform: feature regions that rotate with their sheet, and a built-up
// structure.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/nastran_check.h"

using namespace batten_test;
using batten::Vec3;

namespace {

/// The folder of one example: its script writes the mesh, its scenes run without pictures.
class DeformExample {
 public:
  DeformExample(const std::string& folder, const std::string& mesh, const std::string& script)
      : source_(BATTEN_SOURCE_DIR "/examples/" + folder + "/"), mesh_(mesh), case_(folder) {
    fs::copy(source_ + mesh, case_ / mesh);
    if (std::system("command -v python3 > /dev/null") != 0) {
      WARN("skipped: python3 is not installed");
      return;
    }
    const std::string made = (case_ / "made").string();
    REQUIRE(std::system(("python3 '" + source_ + script + "' > '" + made + "'").c_str()) == 0);
    CHECK(contents(made) == contents(source_ + mesh));
  }

  nlohmann::json run(const std::string& scene) {
    INFO(scene);
    const std::string text = contents(source_ + scene + ".toml");
    case_.file(scene + ".toml", text.substr(0, text.find("[[picture]]")));
    const CliResult r = case_.run({"deform", scene + ".toml", "--out", scene});
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto j = report(case_, scene);
    CHECK(j["failed_checks"].empty());
    CHECK(j["quality"]["inverted"].empty());
    for (const auto& f : j["features"]) CHECK(f["max_rigid_error"].get<double>() < 1e-13);
    return j;
  }

  /// Largest and mean relative change of an edge's length.
  std::pair<double, double> edge_length_change(const std::string& result) const {
    const auto before = batten::MeshFile::read(case_ / mesh_),
               after = batten::MeshFile::read(case_ / result);
    double largest = 0, sum = 0;
    int edges = 0;
    for (int f = 0; f < before.shells().face_count(); ++f) {
      const auto face = before.shells().face(f);
      for (size_t k = 0; k < face.size(); ++k) {
        const int a = face[k], b = face[(k + 1) % face.size()];
        const auto length = [&](const batten::MeshFile& m) {
          return (m.shells().points.row(a) - m.shells().points.row(b)).norm();
        };
        const double change = std::abs(length(after) / length(before) - 1);
        largest = std::max(largest, change);
        sum += change;
        ++edges;
      }
    }
    return {largest, sum / edges};
  }

  fs::path file(const std::string& name) const { return case_ / name; }

  std::map<long, Vec3> nodes(const std::string& file) const {
    const auto m = batten::MeshFile::read(case_ / file);
    std::map<long, Vec3> places;
    for (int v = 0; v < m.shells().node_count(); ++v)
      places[m.node_label(v)] = m.shells().points.row(v);
    return places;
  }

 private:
  std::string source_, mesh_;
  CliCase case_;
};

std::vector<double> rotation_angles(const nlohmann::json& report) {
  std::vector<double> degrees;
  for (const auto& f : report["features"]) degrees.push_back(f["rotation_deg"]);
  return degrees;
}

}  // namespace

TEST_CASE("letters lean with the wall, or stay level where this is prescribed", "[apps][deform]") {
  DeformExample wall("20-letters", "wall.obj", "make_wall.py");
  CHECK(wall.run("free")["features"].empty());
  const auto level = rotation_angles(wall.run("harmonic")),
             found = rotation_angles(wall.run("found")),
             nonlinear = rotation_angles(wall.run("nonlinear")),
             bent = rotation_angles(wall.run("bent"));
  REQUIRE(level.size() == 3);
  // The chord of the lifted part rises by 25.6 degrees, a clamped cubic by up to 36.
  for (size_t k = 0; k < 3; ++k) {
    CHECK(level[k] < 1e-6);
    CHECK(found[k] == Approx(30).margin(5));
    CHECK(nonlinear[k] == Approx(28).margin(5));
    CHECK(bent[k] == Approx(45 + 26 * (k - 1.0)).margin(5));
  }
  CHECK(wall.edge_length_change("nonlinear/wall-deformed.obj").first < 0.2);
  CHECK(wall.edge_length_change("found/wall-deformed.obj").first < 0.2);
  CHECK(wall.edge_length_change("found/wall-deformed.obj").second <
        wall.edge_length_change("harmonic/wall-deformed.obj").second);
  wall.run("bent-free");
}

TEST_CASE("suckers go round with the arm of an octopus", "[apps][deform]") {
  DeformExample arm("21-octopus", "arm.obj", "make_arm.py");
  CHECK(arm.run("free")["features"].empty());
  for (const std::string scene : {"nonlinear", "dual", "harmonic"}) {
    const auto degrees = rotation_angles(arm.run(scene));
    INFO(scene);
    REQUIRE(degrees.size() == 14);
    for (size_t k = 1; k < 14; ++k) CHECK(degrees[k] > degrees[k - 1] + 5);
    CHECK(degrees.back() > 130);
    CHECK(degrees.back() < 150);
  }
  CHECK(arm.edge_length_change("nonlinear/arm-deformed.obj").first < 0.3);
  CHECK(arm.edge_length_change("harmonic/arm-deformed.obj").first > 0.5);
}

TEST_CASE("a head's six organs keep their shape and lean with it", "[apps][deform]") {
  DeformExample head("22-head", "head.obj", "make_head.py");
  CHECK(head.run("free")["features"].empty());
  const auto degrees = rotation_angles(head.run("kept"));
  REQUIRE(degrees.size() == 6);
  // The side towards which the top moves rotates more than the other one does.
  double mean = 0;
  for (const double d : degrees) mean += d / 6;
  CHECK(mean == Approx(14.6).margin(0.5));
  for (size_t a = 0; a < 6; ++a) {
    CHECK(degrees[a] == Approx(mean).margin(4.5));
    // Six features, each with its own rotation.
    for (size_t b = 0; b < a; ++b) CHECK(std::abs(degrees[a] - degrees[b]) > 1e-6);
  }
}

TEST_CASE("a built-up structure becomes longer with everything connected to it", "[apps][deform]") {
  DeformExample deck("23-assembly", "assembly.bdf", "make_deck.py");
  for (const std::string scene : {"longer", "block"}) {
    const auto j = deck.run(scene);
    INFO(scene);
    CHECK(j["attached"]["connections"] == 8);
    CHECK(j["attached"]["max_rigid_error"].get<double>() < 1e-12);
    CHECK(j["attached"]["moved_with_shells"] == 106);
    CHECK(j["attached"]["inverted_solids"].empty());
    int round = 0;
    for (const auto& h : j["holes"]) {
      if (h["nodes"] != 8) continue;
      ++round;
      CHECK(h["after"]["radius"].get<double>() ==
            Approx(h["before"]["radius"].get<double>()).epsilon(1e-9));
    }
    CHECK(round == 5);
    const auto before = deck.nodes("assembly.bdf"),
               after = deck.nodes(scene + "/assembly-" + scene + ".bdf");
    // Small fields round "longer" to 5e-4; large fields leave "block" almost exact.
    const auto original = deck.file("assembly.bdf"),
               edited = deck.file(scene + "/assembly-" + scene + ".bdf");
    check_deck_changes(original, edited, scene == "block" ? 1e-9 : 1e-3);
    // Bolts, the bush, and the motor above the middle of its hole: vertical and with unchanged
    // length.
    for (const auto& [a, b] : {std::pair{477L, 478L}, {479L, 480L}, {104L, 425L}})
      CHECK((after.at(b) - after.at(a) - Vec3(0, 0, 5)).norm() < 2e-3);
    const std::vector<Vec3> block = [&] {
      std::vector<Vec3> places;
      for (const auto& [label, x] : before)
        if (x.x() > 149 && x.x() < 211 && x.y() > 69 && x.y() < 111 && x.z() < 1)
          places.push_back(after.at(label));
      return places;
    }();
    REQUIRE(block.size() == 140);
    double length = 0;
    for (const Vec3& p : block)
      for (const Vec3& q : block) length = std::max(length, (p - q).norm());
    const double as_it_was = Vec3(60, 40, 30).norm();
    if (scene == "block") CHECK(length == Approx(as_it_was).epsilon(1e-9));
    if (scene == "longer") CHECK(length > as_it_was + 2);
  }
}

TEST_CASE("an independent reader of decks finds the data unchanged that an edit must not touch",
          "[apps][deform]") {
  const CliCase c("other_reader");
  const std::string deck = contents(BATTEN_SOURCE_DIR "/examples/23-assembly/assembly.bdf");
  c.file("a.bdf", deck);
  const auto changes = [&](const std::string& from, const std::string& to) {
    std::string edited = deck;
    const size_t at = edited.find(from);
    REQUIRE(at != std::string::npos);
    c.file("b.bdf", edited.replace(at, from.size(), to));
    return deck_changes(c / "a.bdf", c / "b.bdf");
  };
  const auto same = changes("SOL 103", "SOL 103");
  if (same.is_null()) return;
  CHECK(same["other"] == "");
  CHECK(same["moved"] == 0);
  CHECK(same["spiders"] == 5);
  CHECK(same["bent"].get<double>() < 1e-12);
  CHECK(changes("SOL 103", "SOL 101")["other"] == "SOL 101\n");
  CHECK(changes("+       57", "+       58")["other"] != "");
  CHECK(changes("GRID    5   ", "GRID    5005")["other"] != "");
  CHECK(changes("ENDDATA\n", "")["other"] != "");
  // A centre 1 above the eight nodes around it: their mean rises by 1/9.
  const auto bent = changes("60.0000 30.0000 0.0000", "60.0000 30.0000 1.0000");
  CHECK(bent["other"] == "");
  CHECK(bent["moved"] == 1);
  CHECK(bent["bent"].get<double>() == Approx(8.0 / 9));
}
