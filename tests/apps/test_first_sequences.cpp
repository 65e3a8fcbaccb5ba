// SPDX-License-Identifier: MPL-2.0
// Typical first inputs of new users of batten sequence: they give the intended result or a clear
// message.
#include <algorithm>
#include <cmath>

#include "batten/io/sequences/sequence_files.h"
#include "batten/tests/apps/cli_case.h"

using namespace batten_test;
using Catch::Matchers::Contains;

namespace {

/// A flag in the wind: frames of 8 × 4 squares as numbered files in a folder.
void make_flag(const CliCase& c, const std::string& folder, int frames, double swing = 0.2) {
  for (int k = 1; k <= frames; ++k) {
    std::ostringstream text;
    for (int j = 0; j <= 4; ++j)
      for (int i = 0; i <= 8; ++i)
        text << "v " << i << " " << swing * i * std::sin(0.6 * i - 0.4 * k) << " " << j << "\n";
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 8; ++i) {
        const int a = 9 * j + i + 1;
        text << "f " << a << " " << a + 1 << " " << a + 10 << " " << a + 9 << "\n";
      }
    c.file(folder + "/flag_" + std::to_string(k) + ".obj", text.str());
  }
}

/// An edit of that flag: its end moves in frame 3.
std::string scene(const std::string& source = "", const std::string& step = "",
                  const std::string& out = "frames/f_*.obj",
                  const std::string& move = "{ name = \"end\", translate = [0, 1, 0.5] }") {
  return "unit = \"m\"\n[sequence]\nfile = \"flag\"\n" + source +
         "\n[[select]]\nname = \"pole\"\nbox = [[-1, -9, -1], [0.5, 9, 9]]\n"
         "[[select]]\nname = \"end\"\nbox = [[7.5, -9, -1], [9, 9, 9]]\n"
         "[[handle]]\nname = \"end\"\n[[handle]]\nname = \"pole\"\n"
         "[[operation]]\ntype = \"keyframes\"\nfixed = [\"pole\"]\n" +
         step + "\n[[operation.keyframe]]\nframe = 3\nhandle = [" + move +
         "]\n[output]\nframes = \"" + out + "\"\n";
}

CliResult edit(const CliCase& c, const std::string& text, const std::vector<std::string>& more = {},
               const std::string& out = "out") {
  c.file("s.toml", text);
  std::vector<std::string> words = {"sequence", "s.toml", "--out", out};
  words.insert(words.end(), more.begin(), more.end());
  return c.run(words);
}

int files_in(const fs::path& folder) {
  return static_cast<int>(
      std::count_if(fs::directory_iterator(folder), fs::directory_iterator(),
                    [](const auto& entry) { return entry.path().filename().string()[0] != '.'; }));
}

}  // namespace

TEST_CASE("frames of an earlier run with more frames do not stay", "[apps][sequences]") {
  const CliCase c("sequence_stale");
  make_flag(c, "flag", 9);
  REQUIRE(edit(c, scene()).code == 0);
  CHECK(files_in(c / "out/frames") == 9);
  c.file("out/frames/f_100.obj", "of somebody else\n");
  REQUIRE(edit(c, scene("frames = [2, 6]")).code == 0);
  CHECK(files_in(c / "out/frames") == 6);
  CHECK(fs::exists(c / "out/frames/f_0002.obj"));
  CHECK_FALSE(fs::exists(c / "out/frames/f_0009.obj"));
  CHECK(fs::exists(c / "out/frames/f_100.obj"));
}

TEST_CASE("frames are made again when the numbered files of a source change", "[apps][sequences]") {
  const CliCase c("sequence_source");
  make_flag(c, "flag", 5);
  const std::string mix =
      "unit = \"m\"\n[sequence]\nfile = \"flag\"\n"
      "[[select]]\nname = \"end\"\nbox = [[7.5, -9, -1], [9, 9, 9]]\n[[handle]]\nname = \"end\"\n"
      "[[operation]]\ntype = \"mix\"\nalign = \"translate\"\npair = [{ handle = \"end\" }]\n"
      "[operation.source]\nfile = \"other\"\n";
  make_flag(c, "other", 5, 0.1);
  REQUIRE(edit(c, mix).code == 0);
  const std::string first = contents(c / "out/frames/frame_0002.obj");
  REQUIRE(edit(c, mix).code == 0);
  CHECK(report(c, "out")["sequence"]["reused"] == 5);
  make_flag(c, "other", 5, 0.4);
  REQUIRE(edit(c, mix).code == 0);
  CHECK(report(c, "out")["sequence"]["reused"] == 0);
  CHECK(contents(c / "out/frames/frame_0002.obj") != first);
}

TEST_CASE("frames that are there are measured like those that are made", "[apps][sequences]") {
  const CliCase c("sequence_again");
  make_flag(c, "flag", 5);
  for (const std::string ending : {"obj", "off", "ply", "stl", "STL", "vtp", "vtu"}) {
    INFO(ending);
    const std::string text = scene("", "", "f_*." + ending);
    REQUIRE(edit(c, text, {}, ending).code == 0);
    const auto made = report(c, ending);
    fs::remove(c / (ending + "/f_0003." + ending));
    REQUIRE(edit(c, text, {}, ending).code == 0);
    const auto again = report(c, ending);
    CHECK(again["inverted_triangles"] == made["inverted_triangles"]);
    CHECK(again["smoothness"]["second_difference"].get<double>() ==
          Approx(made["smoothness"]["second_difference"].get<double>()));
    CHECK(files_in(c / ending) == 6);
  }
}

TEST_CASE("the report lists files where they are", "[apps][sequences]") {
  const CliCase c("sequence_files");
  make_flag(c, "flag", 4);
  const auto listed = [&](const std::string& out, const std::vector<std::string>& more = {}) {
    fs::remove_all(c / "out");
    const CliResult r = edit(c, scene("", "", out), more);
    INFO(r.err);
    REQUIRE(r.code == 0);
    const auto files = report(c, "out", more.empty() ? "report.json" : "report_2-3.json")["files"];
    for (const std::string file : files) {
      INFO(out << ": " << file);
      CHECK(fs::is_regular_file(c / ("out/" + file)));
    }
    return files.size();
  };
  CHECK(listed("frames/f_*.obj") == 5);
  CHECK(listed("frames/f_*.obj", {"--frames", "2:3"}) == 3);
  CHECK(listed("frames") == 5);
  CHECK(listed("flag.pvd") == 6);
  CHECK(listed("sub/flag.glb") == 2);
  CHECK(listed("sub/FLAG.PC2") == 3);
}

TEST_CASE("endings of single files count in capitals, too", "[apps][sequences]") {
  const CliCase c("sequence_capitals");
  make_flag(c, "flag", 5);
  REQUIRE(edit(c, scene("", "", "f.GLB")).code == 0);
  const auto back = batten::read_frames(c / "out/f.GLB");
  CHECK(back.times.back() == Approx(4.0 / 24));
  const CliResult r = edit(c, scene("", "", "f.PC2"), {"--frames", "1:2"}, "part");
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("expected numbered files"));
}

TEST_CASE("names that no frames can be written to are refused before the steps",
          "[apps][sequences]") {
  const CliCase c("sequence_names");
  make_flag(c, "flag", 3);
  c.fails(scene("", "", "f.gltf"), 1, {"s.toml:", "the extension '.gltf'"}, {}, "sequence");
  c.fails(scene("", "", "f.obj"), 1, {"s.toml:", "a pattern for their numbers, such as f_*.obj"},
          {}, "sequence");
  c.fails(scene("", "", "f_*.glb"), 1, {"s.toml:", "numbered files '.glb'"}, {}, "sequence");
}

TEST_CASE("keys that would do nothing are refused", "[apps][sequences]") {
  const CliCase c("sequence_keys");
  make_flag(c, "flag", 3);
  const auto refused = [&](const std::string& text, const std::string& why) {
    c.fails(text, 1, {"s.toml:", why}, {}, "sequence");
  };
  const auto more = [](const std::string& step) {
    return scene() + "[[operation]]\n" + step + "\n";
  };
  refused(scene("", "keyframe_interval = 5"),
          "key 'keyframe_interval' in an operation of type 'keyframes'");
  refused(more("type = \"root_motion\"\ndirection = [1, 0, 0]\nspeed = 1\npreserve_volume = true"),
          "an operation without handles");
  refused(more("type = \"root_motion\"\ndirection = [1, 0, 0]\nspeed = 1\nfixed = [\"pole\"]"),
          "an operation without handles");
  refused(more("type = \"path\"\nthrough = [[0, 0, 0], [1, 0, 0]]\niterations = 9"),
          "a path without 'feet'");
  refused(scene("", "", "f_*.obj", "{ name = \"end\", translate = [0, 1, 0] }, { name = \"end\" }"),
          "the handle 'end' twice in a keyframe");
  refused(
      scene("", "", "f_*.obj",
            "{ name = \"end\", rotation = \"free\", rotate = { axis = [0, 0, 1], angle = 9 } }"),
      "'rotate' for a handle whose rotation is free");
}

TEST_CASE("a handle with fixed nodes cannot be given a prescribed displacement",
          "[apps][sequences]") {
  const CliCase c("sequence_fixed");
  make_flag(c, "flag", 4);
  const std::string end = "{ name = \"end\", translate = [0, 1, 0] }, ";
  const CliResult r =
      edit(c, scene("", "", "f_*.obj", end + "{ name = \"pole\", translate = [1, 0, 0] }"));
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("'pole' has a prescribed motion, but all its nodes are in fixed"));
  CHECK(edit(c, scene("", "", "f_*.obj", end + "{ name = \"pole\" }")).code == 0);
  std::string wide = scene();
  wide.replace(wide.find("[7.5,"), 5, "[-1,");  // the whole flag including its pole
  REQUIRE(edit(c, wide).code == 0);
  CHECK_THAT(report(c, "out")["warnings"].dump(), Contains("5 of its 45 nodes are fixed"));
}

TEST_CASE("a sequence on the spot has no path, which is reported", "[apps][sequences]") {
  const CliCase c("sequence_spot");
  make_flag(c, "flag", 4);
  const std::string path =
      "unit = \"m\"\n[sequence]\nfile = \"flag\"\n[[operation]]\ntype = \"path\"\n"
      "through = [[0, 0, 0], [10, 0, 0]]\n";
  REQUIRE(edit(c, path).code == 0);
  CHECK_THAT(report(c, "out")["warnings"].dump(), Contains("of its start and has no path"));
}

TEST_CASE("glTF is read at its keys with 0 frames a second", "[apps][sequences]") {
  const CliCase c("sequence_keys_of_gltf");
  make_flag(c, "flag", 5);
  REQUIRE(edit(c, scene("", "", "f.glb")).code == 0);
  fs::rename(c / "out/f.glb", c / "f.glb");
  const CliResult r =
      edit(c,
           "unit = \"m\"\n[sequence]\nfile = \"f.glb\"\nframes_per_second = 0\n[output]\n"
           "frames = \"f_*.obj\"\n");
  INFO(r.err);
  REQUIRE(r.code == 0);
  CHECK(report(c, "out")["sequence"]["frames"] == 5);
}

TEST_CASE("a morph is no bend of features, and every other step is", "[apps][sequences]") {
  const CliCase c("sequence_morphed_features");
  make_flag(c, "flag", 5);
  make_flag(c, "other", 5, 0.1);
  const std::string morph =
      "unit = \"m\"\n[sequence]\nfile = \"flag\"\n"
      "[[select]]\nname = \"end\"\nbox = [[7.5, -9, -1], [9, 9, 9]]\n[[handle]]\nname = \"end\"\n"
      "[[select]]\nname = \"spot\"\nbox = [[2.5, -9, 0.5], [4.5, 9, 2.5]]\n"
      "[[feature]]\nname = \"spot\"\n"
      "[[operation]]\ntype = \"morph\"\ntarget = { file = \"other\" }\n";
  REQUIRE(edit(c, morph).code == 0);
  // The distortion of a handle is reported, also for an operation followed by others.
  const std::string bend =
      "[[operation]]\ntype = \"keyframes\"\n[[operation.keyframe]]\nframe = 2\n"
      "handle = [{ name = \"end\", translate = [0, 3, 0] }]\n"
      "[[operation]]\ntype = \"root_motion\"\ndirection = [1, 0, 0]\nspeed = 1\ncycles = 2\n";
  REQUIRE(edit(c, morph + bend).code == 0);
  const auto j = report(c, "out");
  CHECK(j["sequence"]["frames"] == 10);
  CHECK(j["features"][0]["max_rigid_error"].get<double>() > 0);
  CHECK(j["features"][0]["max_rigid_error"].get<double>() < 1e-12);
}

TEST_CASE("steps that would need more memory than there is are refused", "[apps][sequences]") {
  const CliCase c("sequence_memory");
  make_flag(c, "flag", 4);
  c.fails(scene() +
              "[[operation]]\ntype = \"root_motion\"\ndirection = [1, 0, 0]\nspeed = 1\ncycles = "
              "1000000\n",
          1, {"the operation 'operation-2'", "of memory"}, {"--memory", "1"}, "sequence");
}

TEST_CASE("feet do not slip between keyframes that are far apart", "[apps][sequences]") {
  const CliCase c("sequence_every");
  for (const std::string name : {"walker.obj", "walker.pc2", "stairs.obj"})
    fs::copy(fs::path(BATTEN_SOURCE_DIR "/examples/24-stairs") / name, c / name);
  std::string text = contents(fs::path(BATTEN_SOURCE_DIR "/examples/24-stairs/stairs.toml"));
  text = text.substr(0, text.find("[[picture]]"));
  text.replace(text.find("iterations = 200"), 16, "keyframe_interval = 4");
  const CliResult r = edit(c, text);
  INFO(r.err);
  REQUIRE(r.code == 0);
  const auto j = report(c, "out");
  CHECK(j["operations"][1]["keyframes"].get<int>() < 60);
  for (const auto& f : j["foot_plants"]) CHECK(f["foot_skate"].get<double>() < 1e-9);
}

TEST_CASE("the input is not overwritten", "[apps][sequences]") {
  const CliCase c("sequence_input");
  make_flag(c, "flag", 4);
  const std::string before = contents(c / "flag/flag_3.obj");
  CliResult r = edit(c, scene("", "", "flag/flag_%d.obj"), {}, ".");
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("flag_1.obj: found a file that was not written by batten sequence"));
  CHECK(contents(c / "flag/flag_3.obj") == before);
  REQUIRE(edit(c, scene("", "", "f.pc2")).code == 0);
  const std::string cache = contents(c / "out/f.pc2");
  r = edit(c, "unit = \"m\"\n[sequence]\nfile = \"out/f.pc2\"\n[output]\nframes = \"f.pc2\"\n");
  CHECK(r.code == 1);
  CHECK_THAT(r.err, Contains("input file of this command"));
  CHECK(contents(c / "out/f.pc2") == cache);
  // Frames with two base names in one folder are recognised.
  REQUIRE(edit(c, scene("", "", "f_*.obj")).code == 0);
  REQUIRE(edit(c, scene("", "", "g_*.obj")).code == 0);
  REQUIRE(edit(c, scene("", "", "f_*.obj")).code == 0);
  REQUIRE(edit(c, scene("frames = [1, 3]", "", "f_*.obj")).code == 0);
  CHECK(fs::exists(c / "out/g_0004.obj"));
  CHECK_FALSE(fs::exists(c / "out/f_0004.obj"));
}
