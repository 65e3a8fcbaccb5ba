// SPDX-License-Identifier: MPL-2.0
// The examples of batten sequence: each runs and passes its checks.
#include <algorithm>
#include <cstdlib>

#include "batten/io/sequences/sequence_files.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;
using batten::MeshSequence;
using batten::Points;
using batten::Vec3;
using Catch::Matchers::Contains;

namespace {

using Change = std::pair<std::string, std::string>;

/// The examples side by side as in examples/, without pictures; their scripts write the input.
class SequenceExample {
 public:
  explicit SequenceExample(const std::string& folder) : case_(folder), folder_(folder) {
    for (const std::string& name : {std::string("24-stairs"), folder}) {
      fs::create_directories(case_ / name);
      for (const auto& file : fs::directory_iterator(source(name)))
        if (has_input(file.path()) && !fs::exists(case_ / name / file.path().filename()))
          fs::copy(file.path(), case_ / name / file.path().filename());
    }
    if (std::system("command -v python3 > /dev/null") != 0) {
      WARN("skipped: python3 is not installed");
      return;
    }
    fs::create_directories(case_ / "made");
    REQUIRE(std::system(("python3 -B '" + (source(folder) / "make_input.py").string() + "' '" +
                         (case_ / "made").string() + "'")
                            .c_str()) == 0);
    int files = 0;
    for (const auto& file : fs::directory_iterator(case_ / "made")) {
      INFO(file.path());
      CHECK(contents(file.path()) == contents(source(folder) / file.path().filename()));
      ++files;
    }
    CHECK(files > 0);
  }

  nlohmann::json run(const std::string& scene, const std::string& out = "out",
                     const std::vector<std::string>& more = {}, const Change& change = {}) {
    const CliResult r = result(scene, out, more, change);
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto j = report(case_, out, more.empty() ? "report.json" : "report_49-52.json");
    CHECK(j["failed_checks"].empty());
    for (const auto& f : j["foot_plants"]) CHECK(f["foot_skate"].get<double>() <= 1e-3);
    for (const auto& f : j["features"]) CHECK(f["max_rigid_error"].get<double>() <= 1e-10);
    return j;
  }

  /// The example with one change in its scene is rejected.
  std::string error_message(const std::string& scene, const Change& change) {
    const CliResult r = result(scene, "refused", {}, change);
    CHECK(r.code == 1);
    return r.err;
  }

  /// A sequence of the examples, by its path relative to examples/ or to the results.
  MeshSequence sequence(const std::string& path) const {
    return batten::read_frames(case_ / path);
  }
  fs::path file(const std::string& path) const { return case_ / path; }

 private:
  static fs::path source(const std::string& folder) {
    return fs::path(BATTEN_SOURCE_DIR "/examples") / folder;
  }
  CliResult result(const std::string& scene, const std::string& out,
                   const std::vector<std::string>& more, const Change& change) {
    std::string text = contents(source(folder_) / (scene + ".toml"));
    text = text.substr(0, text.find("[[picture]]"));
    if (!change.first.empty()) {
      const size_t at = text.find(change.first);
      REQUIRE(at != std::string::npos);
      text.replace(at, change.first.size(), change.second);
    }
    case_.file(folder_ + "/" + scene + ".toml", text);
    std::vector<std::string> words = {"sequence", folder_ + "/" + scene + ".toml", "--out", out};
    words.insert(words.end(), more.begin(), more.end());
    return case_.run(words);
  }

  static bool has_input(const fs::path& file) {
    return file.extension() == ".obj" || file.extension() == ".pc2";
  }

  CliCase case_;
  std::string folder_;
};

/// The motion is not much more jerky than before.
bool smooth(const nlohmann::json& report) {
  const auto& s = report["smoothness"];
  return s["second_difference"].get<double>() <= 1.5 * s["second_difference_before"].get<double>();
}

std::vector<int> inside(const Points& p, const Vec3& low, const Vec3& high) {
  std::vector<int> nodes;
  for (int v = 0; v < p.rows(); ++v) {
    const Vec3 x = p.row(v);
    if ((x - low).minCoeff() >= 0 && (high - x).minCoeff() >= 0) nodes.push_back(v);
  }
  return nodes;
}

Vec3 centre(const Points& p, const std::vector<int>& nodes) {
  Vec3 sum = Vec3::Zero();
  for (const int v : nodes) sum += p.row(v).transpose();
  return sum / static_cast<double>(nodes.size());
}

}  // namespace

TEST_CASE("a walker climbs stairs without sliding", "[apps][sequences]") {
  SequenceExample example("24-stairs");
  const auto j = example.run("stairs");
  CHECK(smooth(j));
  CHECK(j["sequence"]["frames"] == 121);
  CHECK(j["foot_plants"].size() == 12);
  const MeshSequence s = example.sequence("out/frames/climb_*.obj");
  CHECK(s.frames.front().col(2).minCoeff() == Approx(0).margin(0.005));
  CHECK(s.frames.back().col(2).minCoeff() == Approx(0.8).margin(0.01));
  // A walker of 1.74 m keeps its height.
  for (const Points& p : s.frames)
    CHECK(p.col(2).maxCoeff() - p.col(2).minCoeff() == Approx(1.7).margin(0.12));
  // Computing only some frames gives the same result.
  example.run("stairs", "some", {"--frames", "49:52"});
  for (const std::string name : {"climb_0048.obj", "climb_0051.obj"})
    CHECK(contents(example.file("some/frames/" + name)) ==
          contents(example.file("out/frames/" + name)));
  CHECK_FALSE(fs::exists(example.file("some/frames/climb_0000.obj")));
}

TEST_CASE("a walker takes a bend and goes over hills", "[apps][sequences]") {
  SequenceExample example("25-path");
  const auto j = example.run("path");
  CHECK(smooth(j));
  CHECK(j["sequence"]["frames"] == 193);
  CHECK(j["foot_plants"].size() == 18);
  const MeshSequence s = example.sequence("out/frames/hills_*.obj");
  const Vec3 way = (s.frames.back() - s.frames.front()).colwise().mean();
  CHECK(way.y() > 2.5);
  CHECK(way.x() > 4);
}

TEST_CASE("corners of a banner follow the hands", "[apps][sequences]") {
  SequenceExample example("26-flag");
  const auto j = example.run("flag");
  CHECK(j["inverted_triangles"]["after"] == 0);
  // Existing frames are reused if the input is unchanged, and computed again otherwise.
  CHECK(example.run("flag")["sequence"]["reused"] == 25);
  const fs::path walker_file = example.file("24-stairs/walker.pc2");
  const std::string walking = contents(walker_file);
  std::string still_walking = walking;
  std::fill(still_walking.end() - 400, still_walking.end(), '\0');
  write(walker_file, still_walking);
  CHECK(example.run("flag")["sequence"]["reused"] == 0);
  write(walker_file, walking);
  CHECK(example.run("flag")["sequence"]["reused"] == 0);
  const MeshSequence banner = example.sequence("out/frames/banner_*.obj"),
                     still = example.sequence("26-flag/banner.pc2"),
                     walker = example.sequence("24-stairs/walker.pc2");
  for (const double side : {1.0, -1.0}) {
    const auto hand = inside(walker.frames[0], Vec3(-1, std::min(0.2 * side, side), 0.5),
                             Vec3(1, std::max(0.2 * side, side), 0.85));
    std::vector<int> corner;
    for (int v = 0; v < still.node_count(); ++v)
      if ((still.frames[0].row(v).transpose() - Vec3(0, 0.8 * side, 0)).norm() <= 0.11)
        corner.push_back(v);
    for (int k = 0; k < banner.frame_count(); ++k) {
      const Vec3 hands_way = centre(walker.frames[k], hand) - centre(walker.frames[0], hand),
                 corners_way = centre(banner.frames[k], corner) - centre(banner.frames[0], corner);
      CHECK((hands_way - corners_way).norm() < 1e-6);
    }
  }
}

TEST_CASE("a jump is announced and overdone, feet stay where they stand", "[apps][sequences]") {
  SequenceExample example("27-cartoon");
  const auto j = example.run("cartoon");
  CHECK(smooth(j));
  CHECK(j["foot_plants"].size() == 4);
  const MeshSequence before = example.sequence("27-cartoon/jumper.pc2"),
                     after = example.sequence("out/frames/jump_*.obj");
  const auto highest = [](const MeshSequence& s) {
    std::vector<double> heights;
    for (const Points& p : s.frames) heights.push_back(p.col(2).maxCoeff());
    return std::pair(*std::ranges::min_element(heights), *std::ranges::max_element(heights));
  };
  CHECK(highest(after).first < highest(before).first - 0.02);
  CHECK(highest(after).second > highest(before).second + 0.02);
  CHECK_THAT(
      example.error_message("cartoon", {"\"left foot\", \"right foot\"]", "\"right foot\"]"}),
      Contains("found the foot 'left foot', expected one of the operation's handles"));
}

TEST_CASE("a worm becomes a fish, both exactly where the morph ends", "[apps][sequences]") {
  SequenceExample example("28-morph");
  const auto j = example.run("morph");
  CHECK(j["inverted_triangles"]["after"] == 0);
  const MeshSequence worm = example.sequence("28-morph/worm.pc2"),
                     fish = example.sequence("28-morph/fish.pc2"),
                     after = example.sequence("out/frames/fish_*.obj");
  REQUIRE(after.frame_count() == 25);
  for (int k = 0; k <= 6; ++k)
    CHECK((after.frames[k] - worm.frames[k]).cwiseAbs().maxCoeff() < 1e-9);
  // Wherever it swims: the fish keeps its length and its height.
  int nose = 0, tail = 0;
  fish.frames[6].col(0).maxCoeff(&nose);
  fish.frames[6].col(0).minCoeff(&tail);
  const auto last = worm.node_count() - 1;
  const auto height = [](const Points& p) { return p.col(2).maxCoeff() - p.col(2).minCoeff(); };
  for (int k = 18; k < 25; ++k) {
    const Points &made = after.frames[k], &meant = fish.frames[k];
    CHECK((made.row(0) - made.row(last)).norm() ==
          Approx((meant.row(nose) - meant.row(tail)).norm()).epsilon(5e-4));
    CHECK(height(made) == Approx(height(meant)).epsilon(0.02));
  }
  // Also for a fish with inverted faces.
  std::istringstream faces(contents(example.file("28-morph/fish.obj")));
  std::string line, inside_out;
  while (std::getline(faces, line)) {
    std::istringstream in(line);
    std::vector<std::string> words;
    for (std::string word; in >> word;) words.push_back(word);
    if (words[0] == "f") std::reverse(words.begin() + 1, words.end());
    for (const auto& word : words) inside_out += word + " ";
    inside_out += "\n";
  }
  write(example.file("28-morph/inside_out.obj"), inside_out);
  example.run("morph", "turned", {}, {"\"fish.pc2\"", "\"fish.pc2\", mesh = \"inside_out.obj\""});
  const MeshSequence turned = example.sequence("turned/frames/fish_*.obj");
  for (int k = 0; k < 25; ++k)
    CHECK((turned.frames[k] - after.frames[k]).cwiseAbs().maxCoeff() < 1e-6);
  CHECK_THAT(
      example.error_message("morph", {"interval = [7, 19] }", "interval = [27, 29] }"}),
      Contains("the interval of the target is frames 27 to 29, expected two frames of 1 to 25"));
}

TEST_CASE("a flange becomes wider while a plate is pressed, holes keep their shape",
          "[apps][sequences]") {
  SequenceExample example("29-forming");
  const auto j = example.run("forming");
  CHECK(smooth(j));
  CHECK(j["features"].size() == 3);
  CHECK(j["inverted_triangles"]["after"] == 0);
  const MeshSequence before = example.sequence("29-forming/plate.pc2"),
                     after = example.sequence("out/frames/forming_*.vtp");
  REQUIRE(after.frame_count() == before.frame_count());
  CHECK((after.frames.front() - before.frames.front()).cwiseAbs().maxCoeff() < 1e-9);
  const auto edge = inside(before.frames[0], Vec3(-1, -1, -1), Vec3(1, 161, 1)),
             flange = inside(before.frames[0], Vec3(210, -1, -1), Vec3(241, 161, 1));
  REQUIRE(!edge.empty());
  REQUIRE(!flange.empty());
  for (const int v : edge)
    CHECK((after.frames.back().row(v) - before.frames.back().row(v) + Eigen::RowVector3d(10, 0, 0))
              .norm() < 1e-9);
  double last = 0;
  for (int k = 0; k < before.frame_count(); ++k) {
    const double moved = (before.frames[k] - after.frames[k])(edge[0], 0);
    CHECK(moved >= last);  // grows from frame to frame
    last = moved;
    for (const int v : flange)
      CHECK((after.frames[k].row(v) - before.frames[k].row(v)).norm() < 1e-9);
  }
  example.run("forming", "late", {}, {"[1, 21]", "[10, 21]"});
  const MeshSequence late = example.sequence("late/frames/forming_*.vtp");
  for (int k = 0; k < 10; ++k) CHECK(late.frames[k] == before.frames[k]);
  CHECK_THAT(example.error_message("forming", {"[1, 21]", "[10, 20]"}), Contains("frame 20"));
}
