// SPDX-License-Identifier: MPL-2.0
// Sequences of <batten/batten.h>: same frames as batten sequence, and the words of refusals.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>

#include "batten/batten.h"
#include "batten/io/scene/sequence_scene.h"
#include "batten/scenes/commands.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"

using namespace batten;
using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

/// An empty folder that is deleted at the end.
struct Folder {
  Folder() { fs::remove_all(path); }
  ~Folder() { fs::remove_all(path); }
  fs::path path = fs::temp_directory_path() / "batten_test_sequence";
};

/// A strip of quads (i, j, 0), i = 0 … 8, j = 0 … 2, that bends back and forth in nine frames.
Sequence bending() {
  constexpr int length = 8, width = 2, count = 9;
  std::vector<std::vector<int>> faces;
  const auto vertex = [](int i, int j) { return 3 * i + j; };
  for (int i = 0; i < length; ++i)
    for (int j = 0; j < width; ++j)
      faces.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
  std::vector<Points> frames;
  for (int k = 0; k < count; ++k) {
    Points p((length + 1) * (width + 1), 3);
    for (int i = 0; i <= length; ++i)
      for (int j = 0; j <= width; ++j)
        p.row(vertex(i, j)) << i, j, 0.02 * i * i * std::sin(std::numbers::pi * k / 4);
    frames.push_back(p);
  }
  return Sequence(std::move(frames), faces);
}

bool same_frames(const Sequence& a, const Sequence& b) {
  bool same = a.frame_count() == b.frame_count();
  for (int k = 0; same && k < a.frame_count(); ++k) same = a.frame(k) == b.frame(k);
  return same;
}

SequenceSettings ends_of(const Sequence& s) {
  SequenceSettings settings;
  settings.fixed = s.mesh().vertices_in({-1, -1, -1}, {0.5, 3, 1});
  settings.handles = {{"end", s.mesh().vertices_in({7.5, -1, -1}, {9, 3, 1})}};
  return settings;
}

}  // namespace

TEST_CASE("edits in memory give the frames of batten sequence", "[scenes][sequence]") {
  const Folder folder;
  fs::create_directories(folder.path);
  const Sequence s = bending();
  s.save(folder.path / "in/s_*.vtp");
  const std::string edits =
      "up = \"y\"\n[[select]]\nname = \"start\"\nbox = [[-1, -1, -1], [0.5, 3, 1]]\n"
      "[[select]]\nname = \"end\"\nbox = [[7.5, -1, -1], [9, 3, 1]]\n[[handle]]\nname = \"end\"\n";
  const std::string keyframe =
      "[[operation]]\ntype = \"keyframes\"\nfixed = \"start\"\ninfluence = [1, 9]\n"
      "[[operation.keyframe]]\nframe = 5\nhandle = [{ name = \"end\", translate = [0, 0, 2], "
      "rotate = { axis = [0, 1, 0], angle = -20 } }]\n";
  const std::string filter =
      "[[operation]]\ntype = \"filter\"\nfilter = \"low\"\nhandles = \"end\"\nfixed = \"start\"\n"
      "sigma = 1.5\n";
  SequenceScene scene = parse_sequence_scene("unit = \"m\"\n" + edits + keyframe + filter +
                                                 "[sequence]\nfile = \"in/s_*.vtp\"\n" +
                                                 "[output]\nframes = \"f_*.vtp\"\n",
                                             folder.path / "s.toml");
  std::ofstream(folder.path / "s.toml") << "# the fingerprint of the run\n";
  const SequenceReport report = run_sequence(scene, folder.path / "out");
  CHECK(report.failed_checks.empty());
  const Sequence written = read_sequence(folder.path / "out/f_*.vtp");

  const Sequence edited = s.edited(edits + keyframe + filter);
  CHECK(same_frames(edited, written));
  CHECK(edited.failed_checks().empty());
  CHECK_THAT(edited.report(), Contains("\"keyframes\""));

  Move move{.translate = {0, 0, 2}, .axis = {0, 1, 0}, .angle = -20};
  const SequenceSettings settings = ends_of(s);
  const Sequence moved = s.keyframes({{4, {{"end", move}}}}, settings, std::pair(0, 8));
  CHECK(same_frames(moved.filter("low", settings, 1.5), written));
  CHECK(moved.frame(0) == s.frame(0));
  CHECK((moved.frame(4) - s.frame(4)).cwiseAbs().maxCoeff() > 1);
  CHECK_FALSE(same_frames(moved, written));
}

TEST_CASE("a morph into itself changes nothing, and a mix follows the source",
          "[scenes][sequence]") {
  const Sequence s = bending();
  const Sequence same = s.morph(s);
  REQUIRE(same.frame_count() == 9);
  for (int k = 0; k < 9; ++k) CHECK((same.frame(k) - s.frame(k)).cwiseAbs().maxCoeff() < 1e-9);
  MorphSettings part;
  part.interval = part.target_interval = std::pair(2, 5);
  part.frames = 7;
  const Sequence longer = s.morph(s, part);
  CHECK(longer.frame_count() == 12);
  CHECK(longer.frame(1) == s.frame(1));

  std::vector<Points> still(9, s.frame(0));
  const Sequence sheet(still, s.mesh());
  SequenceSettings settings = ends_of(s);
  const std::vector<int> end = settings.handles.front().vertices;
  const Sequence follows =
      sheet.mix(s, {{"end", {}}}, settings, "align = 'translate', rotations = false");
  for (int k = 0; k < 9; ++k) {
    Vec3 shift = Vec3::Zero(), wanted = Vec3::Zero();
    for (const int v : end) {
      shift += (follows.frame(k) - follows.frame(0)).row(v).transpose();
      wanted += (s.frame(k) - s.frame(0)).row(v).transpose();
    }
    CHECK((shift - wanted).norm() < 1e-9);
  }
}

TEST_CASE("sequences are saved and read", "[scenes][sequence]") {
  const Folder folder;
  fs::create_directories(folder.path);
  const Sequence s = bending();
  CHECK(s.save(folder.path / "f/s_*.vtp").size() == 9);
  CHECK(same_frames(read_sequence(folder.path / "f"), s));
  SequenceOptions options;
  options.first = 3;
  options.last = 4;
  CHECK(read_sequence(folder.path / "f", options).frame(0) == s.frame(2));
  CHECK(s.mesh(3).points() == s.frame(3));
  CHECK(s.faces().size() == 16);
  CHECK(s.times() == std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9});
  CHECK_THAT(error_message([&] { s.save(folder.path / "s.glb", 0); }),
             Contains("frames_per_second: found 0"));
}

TEST_CASE("invalid sequences and edits are refused by name", "[scenes][sequence]") {
  const Sequence s = bending();
  const SequenceSettings settings = ends_of(s);
  std::vector<Points> bad(2, s.frame(0));
  bad[1](3, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(error_message([&] { Sequence(bad, s.faces()); }), Contains("frame 2: node 4"));
  CHECK_THAT(error_message([&] { Sequence({}, s.faces()); }), Contains("frames: found none"));
  CHECK_THAT(error_message([&] {
               Sequence(std::vector(1, s.frame(0)), std::vector<std::vector<int>>{{0, 1, 99}});
             }),
             Contains("faces: found 99"));
  CHECK_THAT(error_message([&] { s.frame(9); }), Contains("expected 0 to 8"));
  CHECK_THAT(error_message([&] { s.filter("low", settings, -1); }),
             Catch::Matchers::StartsWith("filter(): ") && Contains("sigma"));
  CHECK_THAT(error_message([&] { s.filter("low", settings, 2, "wieghts = 'uniform'"); }),
             Contains("filter(): found key 'wieghts'") && Contains("did you mean 'weights'"));
  CHECK_THAT(error_message([&] {
               s.keyframes({{4, {{"edn", {}}}}}, settings);
             }),
             Contains("keyframes(): found the handle 'edn'"));
  SequenceSettings more = settings;
  more.sequences.emplace("fish", s);
  CHECK_THAT(error_message([&] {
               s.edited("[[operation]]\ntype = \"morph\"\ntarget = { file = \"fsh\" }\n", more);
             }),
             Contains("edited():3:19: found the sequence 'fsh'") && Contains("'fish'"));
  more.parents = {{"end", "ned"}};
  CHECK_THAT(error_message([&] { s.filter("low", more); }), Contains("parents: found"));
  more = settings;
  more.features = {{"end", {1}}};
  CHECK_THAT(error_message([&] { s.filter("low", more); }), Contains("feature 'end'"));
  more = settings;
  more.handles.front().vertices = {100};
  CHECK_THAT(error_message([&] { s.filter("low", more); }), Contains("handle 'end': found 100"));
}
