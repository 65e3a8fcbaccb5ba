// SPDX-License-Identifier: MPL-2.0
// batten sequence on the command line.
#include <map>

#include "batten/io/sequences/sequence_files.h"
#include "batten/io/sequences/sequence_writer.h"
#include "batten/tests/apps/cli_case.h"
#include "batten/tests/support/reference_frame_solver.h"

using namespace batten_test;

namespace {

/// A bar whose ends are feet: it walks on the spot along x, 16 frames per cycle, with the first one
/// repeated at the end. A foot stands for half a cycle and slides back by 1/16 per frame.
MeshSequence walk_on_the_spot() {
  const TriangleMesh mesh = bar(8, 2, 1, 0.4);
  MeshSequence s;
  for (const auto& t : mesh.triangles()) s.shells.add_face(t);
  for (int k = 0; k <= 16; ++k) {
    Points p = mesh.points();
    for (int v = 0; v < p.rows(); ++v) {
      const auto foot = [&](int phase) {
        phase %= 16;
        return phase < 8 ? Vec3(0.25 - 0.0625 * phase, 0, 0)
                         : Vec3(-0.25 + 0.0625 * (phase - 8), 0,
                                0.1 * std::sin(std::numbers::pi * (phase - 8) / 8));
      };
      const double f = p(v, 0);
      p.row(v) += ((1 - f) * foot(k) + f * foot(k + 8)).transpose();
    }
    s.frames.push_back(p);
    s.times.push_back(k);
  }
  s.shells.points = s.frames.front();
  return s;
}

void write_frames(const fs::path& path, const MeshSequence& s) {
  fs::create_directories(path.parent_path());
  SequenceWriter writer(path, s.shells, s.times);
  for (int k = 0; k < s.frame_count(); ++k)
    if (!writer.has(k)) writer.write(k, s.frames[k]);
  writer.finish();
}

/// Keys before the operations.
const std::string kSequenceHead =
    "unit = \"mm\"\n[sequence]\nfile = \"in/walk_*.obj\"\n"
    "[[select]]\nname = \"a\"\nbox = [[0.74,-1,-1],[0.76,1,1]]\n"
    "[[select]]\nname = \"b\"\nbox = [[0.24,-1,-1],[0.26,1,1]]\n"
    "[[handle]]\nname = \"front\"\nvertices = \"b\"\n"
    "[[handle]]\nname = \"back\"\nvertices = \"a\"\n";
const std::string kKeyframes =
    "[[operation]]\ntype = \"keyframes\"\n[[operation.keyframe]]\nframe = 9\n"
    "handle = [{ name = \"front\", translate = [0, 0, 0.3], rotate = { axis = [0,1,0], angle = "
    "20 "
    "} },\n          { name = \"back\" }]\n";

void put_walk(const CliCase& c) { write_frames(c / "in/walk_*.obj", walk_on_the_spot()); }

std::string with_step(const std::string& step) { return kSequenceHead + "[[operation]]\n" + step; }

/// A finished run and its report. Each range of frames has a separate report.
std::string report_name(const std::vector<std::string>& words) {
  const auto at = std::find(words.begin(), words.end(), "--frames");
  if (at == words.end()) return "report.json";
  std::string part = *(at + 1);
  std::replace(part.begin(), part.end(), ':', '-');
  return "report_" + part + ".json";
}

nlohmann::json done(const CliCase& c, const std::string& scene, const std::string& out = "out",
                    const std::vector<std::string>& more = {}) {
  c.file("s.toml", scene);
  std::vector<std::string> words{"sequence", "s.toml", "--out", out};
  words.insert(words.end(), more.begin(), more.end());
  const CliResult r = c.run(words);
  INFO(scene << "\n" << r.out << r.err);
  CHECK(r.code == 0);
  return r.code == 0 ? report(c, out, report_name(more)) : nlohmann::json();
}

std::map<std::string, std::string> contents_in(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::directory_iterator(folder))
    all[entry.path().filename().string()] = contents(entry.path());
  return all;
}

}  // namespace

TEST_CASE("every kind of step goes over a walk", "[apps][sequences]") {
  const CliCase c("sequence_kinds");
  put_walk(c);
  const std::string feet = "feet = [\"front\", \"back\"]\n",
                    found = "contact_detection = { distance = 0.02 }\n";
  const std::string travel = "type = \"root_motion\"\ncycles = 2\ndirection = [1,0,0]\n" + feet;
  nlohmann::json j = done(c, with_step(travel));
  CHECK(j["sequence"]["frames"].get<int>() == 33);
  const MeshSequence far = read_frames(c / "out/frames");
  CHECK(far.frame_count() == 33);
  const MeshSequence before = walk_on_the_spot();
  CHECK(distance(far.frames[20],
                 (before.frames[4].rowwise() + Eigen::RowVector3d(1.25, 0, 0)).eval()) < 1e-12);
  const std::string then = travel + "[[operation]]\n";
  std::string terrain = "v -20 -20 0\nv 40 -20 6\nv 40 20 6\nv -20 20 0\nf 1 2 3\nf 1 3 4\n";
  c.file("hill.obj", terrain);
  j = done(c, with_step(then + "type = \"foot_plants\"\n" + feet + found +
                        "terrain = { file = \"hill.obj\" }\n"));
  REQUIRE(j["foot_plants"].size() >= 4);
  for (const auto& foot : j["foot_plants"]) CHECK(foot["foot_skate"].get<double>() < 1e-12);
  j = done(c, with_step(then + "type = \"path\"\nthrough = [[0,0,0],[1,0.3,0],[2,1.2,0]]\n" + feet +
                        found));
  for (const auto& foot : j["foot_plants"]) CHECK(foot["foot_skate"].get<double>() < 1e-12);
  j = done(c, with_step(then +
                        "type = \"filter\"\nfilter = \"low\"\nhandles = [\"front\", \"back\"]\n"));
  CHECK(j["operations"].size() == 2);
  j = done(
      c, with_step("type = \"mix\"\nsource = { file = \"in/walk_*.obj\", select = [{ name = \"x\", "
                   "box = [[0.74,-1,-1],[0.76,1,1]] }] }\npair = [{ handle = \"back\", from = "
                   "\"x\" }]\n"));
  // A handle prescribed to its own motion changes nothing.
  CHECK(distance(read_frames(c / "out/frames").frames[5], before.frames[5]) < 1e-9);
  j = done(c,
           with_step("type = \"morph\"\ntarget = { file = \"in/walk_*.obj\", interval = [3, 10] }\n"
                     "interval = [5, 12]\n"));
  CHECK(j["sequence"]["frames"].get<int>() == 4 + 8 + 7);
  j = done(c, kSequenceHead + kKeyframes);
  CHECK(j["operations"][0]["keyframes"].get<int>() == 1);
}

TEST_CASE("an unrotated trunk stays on the path, and on a slope follows the mean of the feet",
          "[apps][sequences]") {
  const CliCase c("sequence_upright");
  put_walk(c);
  c.file("hill.obj", "v -20 -20 0\nv 40 -20 6\nv 40 20 6\nv -20 20 0\nf 1 2 3\nf 1 3 4\n");
  const std::string feet = "feet = [\"front\", \"back\"]\n",
                    found = "contact_detection = { distance = 0.02 }\n";
  const std::string head =
      "[[handle]]\nname = \"trunk\"\nvertices = \"t\"\n[[select]]\nname = \"t\"\nbox = "
      "[[0.49,-1,-1],[0.51,1,1]]\n[[operation]]\ntype = \"root_motion\"\ndirection = [1,0,0]\n" +
      feet + "[[operation]]\n";
  const std::vector<int> trunk = nodes_where(
      walk_on_the_spot().frames[0], [](const Vec3& p) { return std::abs(p.x() - 0.5) < 0.011; });
  REQUIRE(!trunk.empty());
  const auto frames = [&](const std::string& step) {
    done(c, kSequenceHead + head + step);
    return read_frames(c / "out/frames").frames;
  };
  const std::string bend = "type = \"path\"\nthrough = [[0,0,0],[1,0.3,0],[2,1.2,0]]\n";
  const auto along = trajectory_of(frames(bend), trunk),
             held = trajectory_of(frames(bend + feet + found + "unrotated = \"trunk\"\n"), trunk);
  CHECK(distance(along.centres, held.centres) < 1e-12);
  const auto flat = frames("type = \"foot_plants\"\n" + feet + found),
             hill = frames("type = \"foot_plants\"\n" + feet + found +
                           "unrotated = \"trunk\"\nterrain = { file = \"hill.obj\" }\n");
  const auto before = trajectory_of(flat, trunk), after = trajectory_of(hill, trunk);
  const auto expected = trajectory_of(
      frames("type = \"foot_plants\"\n" + feet + found + "unrotated = \"trunk\"\n"), trunk);
  for (int k = 0; k < after.frame_count(); ++k) {
    CHECK((after.rotations[k] - expected.rotations[k]).norm() <
          1e-9);                                            // as on level ground: it does not lean
    CHECK(after.centres(k, 2) > before.centres(k, 2) + 1);  // the hill is 2 high at its start
  }
}

TEST_CASE("invalid sequences are refused with file and position, and leave nothing",
          "[apps][sequences]") {
  const CliCase c("sequence_refused");
  put_walk(c);
  const auto refused = [&](const std::string& scene, const std::vector<std::string>& parts) {
    c.fails(scene, 1, parts, {}, "sequence");
  };
  const std::string frame = kKeyframes.substr(kKeyframes.find("[[operation.keyframe]]"));
  refused(kSequenceHead + "[[operation]]\ntype = \"keyframe\"\n",
          {"s.toml:17:8: found 'keyframe'", "keyframes"});
  refused(with_step("type = \"keyframes\"\nsigma = 2\n" + frame),
          {"s.toml:18:", "key 'sigma' in an operation of type 'keyframes'"});
  refused(with_step("type = \"root_motion\"\ndirection = [1,0,0]\nspeed = 1\nfeet = \"front\"\n"),
          {"s.toml:16:", "the speed given twice or not at all", "one of speed, feet"});
  refused(with_step("type = \"keyframes\"\n[[operation.keyframe]]\nframe = 18\nhandle = [{ name = "
                    "\"front\" }]\n"),
          {"s.toml:18:", "found frame 18, expected one of 1 to 17"});
  refused(with_step("type = \"keyframes\"\n[[operation.keyframe]]\nframe = 3\nhandle = [{ name = "
                    "\"frond\" }]\n"),
          {"s.toml:20:", "found the handle 'frond'", "front"});
  refused(with_step("type = \"keyframes\"\ninfluence = [4, 8]\n" + frame),
          {"s.toml:16:", "operation-1"});
  refused(kSequenceHead +
              "[[select]]\nname = \"none\"\nbox = [[9,9,9],[10,10,10]]\n[[handle]]\nname = "
              "\"hand\"\nvertices = \"none\"\n" +
              kKeyframes,
          {"s.toml:", "none"});
  refused("unit = \"mm\"\n[sequence]\nfile = \"gone_*.obj\"\n", {"s.toml:3:8: ", "gone_"});
  refused("unit = \"mm\"\n", {"s.toml"});

  const std::string five = contents(c / "in/walk_0005.obj");
  fs::remove(c / "in/walk_0005.obj");
  refused(kSequenceHead + kKeyframes, {"s.toml:3:8: ", "5"});
  c.file("in/walk_0005.obj", five.substr(0, five.rfind("f ")));
  refused(kSequenceHead + kKeyframes, {"s.toml:3:8: ", "walk_0005.obj"});
  std::string nan = five;
  nan.replace(nan.find("v ") + 2, 1, "nan ");
  c.file("in/walk_0005.obj", nan);
  refused(kSequenceHead + kKeyframes, {"s.toml:3:8: ", "walk_0005.obj"});
  c.file("in/walk_0005.obj", five);

  write_frames(c / "cache.pc2", walk_on_the_spot());
  const std::string cache = contents(c / "cache.pc2");
  c.file("short.pc2", cache.substr(0, cache.size() - 10));
  refused("unit = \"mm\"\n[sequence]\nfile = \"short.pc2\"\nmesh = \"cache.obj\"\n",
          {"s.toml:3:8: ", "short.pc2"});
  for (const std::string file : {"one.pc2", "all.pvd"}) {
    c.file("s.toml", kSequenceHead + kKeyframes + "[output]\nframes = \"" + file + "\"\n");
    const CliResult r = c.run({"sequence", "s.toml", "--out", "out", "--frames", "1:4"});
    CHECK(r.code == 1);
    CHECK(r.err.find("expected numbered files") != std::string::npos);
    CHECK_FALSE(fs::exists(c / ("out/" + file)));
  }
}

TEST_CASE("parts of the frames are the whole's, and a run goes on where it was stopped",
          "[apps][sequences]") {
  const CliCase c("sequence_parts");
  put_walk(c);
  const std::string scene = kSequenceHead + kKeyframes;
  done(c, scene, "whole");
  const auto whole = contents_in(c / "whole/frames");
  for (const std::string part : {"1:5", "6:6", "7:17"}) {
    const auto j = done(c, scene, "parts", {"--frames", part});
    CHECK(j["sequence"]["reused"].get<int>() == 0);
  }
  CHECK(contents_in(c / "parts/frames") == whole);
  // Some exist, others do not.
  fs::remove(c / "parts/frames/frame_0003.obj");
  fs::remove(c / "parts/frames/frame_0009.obj");
  CHECK(done(c, scene, "parts")["sequence"]["reused"].get<int>() == 15);
  CHECK(contents_in(c / "parts/frames") == whole);
  // Another scene and other input: all frames are computed again.
  std::string other = scene;
  other.replace(other.find("0.3]"), 3, "0.2");
  CHECK(done(c, other, "parts")["sequence"]["reused"].get<int>() == 0);
  CHECK(contents_in(c / "parts/frames") != whole);
  MeshSequence moved_walk = walk_on_the_spot();
  for (Points& p : moved_walk.frames) p(7, 2) += 1e-3;
  fs::remove_all(c / "in");
  write_frames(c / "in/walk_*.obj", moved_walk);
  CHECK(done(c, other, "parts")["sequence"]["reused"].get<int>() == 0);
}

TEST_CASE("frames are written as folders, caches, scenes and lists", "[apps][sequences]") {
  const CliCase c("sequence_files");
  put_walk(c);
  done(c, kSequenceHead + kKeyframes);
  const MeshSequence wanted = read_frames(c / "out/frames");
  for (const std::string file : {"new.pc2", "new.glb", "new.pvd", "new/walk_%03d.ply"}) {
    INFO(file);
    done(c, kSequenceHead + kKeyframes + "[output]\nframes = \"" + file + "\"\n", "as");
    SequenceOptions options;
    if (file == "new.pc2") options.mesh = c / "as/new.obj";
    const fs::path path = file.starts_with("new/") ? c / "as/new" : c / ("as/" + file);
    const MeshSequence found = read_frames(path, options);
    REQUIRE(found.frame_count() == wanted.frame_count());
    for (const int k : {0, 8, 16}) {
      CHECK((found.frames[k].colwise().mean() - wanted.frames[k].colwise().mean()).norm() < 0.05);
      if (found.node_count() == wanted.node_count())
        CHECK(distance(found.frames[k], wanted.frames[k]) < 1e-5);
    }
    fs::remove_all(c / "as");
  }
}

TEST_CASE("the fox walks over a hill and along a path, and starts to run",
          "[apps][sequences][data]") {
  const auto fox = optional_data("seq-fox");
  if (fox.empty()) {
    WARN("skipped: no seq-fox beside the project (BATTEN_TEST_DATA)");
    return;
  }
  const CliCase c("sequence_fox");
  const std::string head =
      "unit = \"cm\"\nup = \"y\"\n[sequence]\nfile = \"" +
      (fox / "walk/fox_walk_000.obj").string() +
      "\"\nframes = [1, 24]\n"
      "[[select]]\nname = \"hind\"\nbox = [[4,-1,-44],[10,3,-35]]\n"
      "[[select]]\nname = \"other\"\nbox = [[-10,-1,-18],[-4,3,-10]]\n"
      "[[select]]\nname = \"fore\"\nbox = [[-9,-1,3],[-5,3,6]]\n"
      "[[handle]]\nname = \"hind\"\n[[handle]]\nname = \"other\"\n[[handle]]\nname = \"fore\"\n"
      "[[operation]]\nname = \"far\"\ntype = \"root_motion\"\ncycles = 2\ndirection = "
      "[0,0,1]\nfeet = [\"hind\", "
      "\"other\", \"fore\"]\n";
  std::string hill;
  for (int j = 0; j <= 20; ++j)
    for (int i = 0; i <= 40; ++i)
      hill += "v " + std::to_string(10 * (j - 10)) + " " + std::to_string(6 * std::sin(0.25 * i)) +
              " " + std::to_string(15 * (i - 15)) + "\n";
  for (int j = 0; j < 20; ++j)
    for (int i = 0; i < 40; ++i) {
      const int a = 41 * j + i + 1;
      hill += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " +
              std::to_string(a + 42) + " " + std::to_string(a + 41) + "\n";
    }
  c.file("hill.obj", hill);
  const std::string feet =
      "feet = [\"hind\", \"other\", \"fore\"]\ncontact_detection = { distance = 4 }\n";
  const auto looked_at = [&](const nlohmann::json& j, const std::string& what) {
    const double before = j["smoothness"]["second_difference_before"].get<double>(),
                 after = j["smoothness"]["second_difference"].get<double>();
    INFO(what << ": feet " << j["foot_plants"].size() << ", second difference " << before << " -> "
              << after);
    CHECK(j["foot_plants"].size() >= 3);
    for (const auto& foot : j["foot_plants"]) CHECK(foot["foot_skate"].get<double>() <= 1e-12);
    CHECK(after <= 1.5 * before);
  };
  looked_at(
      done(c, head +
                  "[[operation]]\nname = \"hill\"\ntype = \"foot_plants\"\nterrain = { file = "
                  "\"hill.obj\" }\n" +
                  feet),
      "hill");
  looked_at(
      done(c, head +
                  "[[operation]]\nname = \"along\"\ntype = \"path\"\nthrough = [[0,0,0],[20,0,100],"
                  "[80,0,200],[180,0,260]]\n" +
                  feet),
      "path");
  const std::string run = (fox / "run/fox_run_000.obj").string();
  const auto j =
      done(c, head + "[[operation]]\nname = \"run\"\ntype = \"morph\"\ntarget = { file = \"" + run +
                  "\", interval = [1, 12] }\ninterval = [30, 40]\n");
  CHECK(j["sequence"]["frames"].get<int>() > 40);
  CHECK(j["inverted_triangles"]["after"].get<int>() <=
        3 * j["inverted_triangles"]["before"].get<int>() + 20);
  // The head of the running fox on the walking fox.
  const std::string box = "box = [[-25,30,40],[25,90,80]]";
  const auto mixed = done(c, "unit = \"cm\"\nup = \"y\"\n[sequence]\nfile = \"" +
                                 (fox / "walk/fox_walk_000.obj").string() +
                                 "\"\nframes = [1, 24]\n[[select]]\nname = \"head\"\n" + box +
                                 "\n[[handle]]\nname = \"head\"\n[[operation]]\nname = "
                                 "\"mixed\"\ntype = \"mix\"\nkeyframe_interval "
                                 "= 2\nsource = { file = \"" +
                                 run + "\", select = [{ name = \"there\", " + box +
                                 " }] }\npair = [{ handle = \"head\", from = \"there\" }]\n");
  CHECK(mixed["handles"][0]["max_rigid_error"].get<double>() < 1e-10);
}
