// SPDX-License-Identifier: MPL-2.0
// Numbered files, lists of files and point caches: valid and invalid sequences.
#include <limits>

#include "batten/tests/io/sequences/sequence_file_helpers.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

fs::path folder_of(const std::string& name) { return scratch("sequence_files/" + name); }

/// One triangle at height z.
std::string triangle(double z) {
  return "v 0 0 " + std::to_string(z) + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
}

std::string stl_text(const std::vector<std::array<Vec3, 3>>& triangles) {
  std::string text = "solid a\n";
  for (const auto& corners : triangles) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const Vec3& p : corners)
      text += "vertex " + std::to_string(p[0]) + " " + std::to_string(p[1]) + " " +
              std::to_string(p[2]) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid a\n";
}

}  // namespace

TEST_CASE("numbered files come in the order of their numbers", "[io][sequences]") {
  const fs::path folder = folder_of("order");
  for (const int k : {8, 9, 10, 11})
    put_bytes(folder / ("w" + std::to_string(k) + ".obj"), triangle(k));
  put_bytes(folder / "w_rest.obj", "v 0 0 0\n");
  put_bytes(folder / "other1.obj", "v 0 0 0\n");
  for (const fs::path& path : {folder, folder / "w*.obj", folder / "w%d.obj", folder / "w10.obj"}) {
    INFO(path);
    const MeshSequence s = read_frames(path);
    CHECK(s.times == std::vector<double>{8, 9, 10, 11});
    REQUIRE(s.frame_count() == 4);
    for (int k = 0; k < 4; ++k) CHECK(s.frames[k](0, 2) == 8 + k);
    CHECK(s.shells.points(0, 2) == 8);
  }
  SequenceOptions part;
  part.first = 2;
  part.last = 3;
  const MeshSequence s = read_frames(folder, part);
  CHECK(s.times == std::vector<double>{9, 10});
  CHECK(s.shells.points(0, 2) == 9);
  part.last = 5;
  CHECK_THAT(reading(folder, part), Contains("w*.obj: found 4 frames, expected frames 2 to 5"));
  part.first = 5;
  part.last = 0;
  CHECK_THAT(reading(folder, part), Contains("found 4 frames, expected frames 5 to the end"));
}

TEST_CASE("missing numbers are named, strides are none", "[io][sequences]") {
  const fs::path folder = folder_of("gaps");
  for (const int k : {0, 10, 20, 50})
    put_bytes(folder / ("a" + std::to_string(k) + ".obj"), triangle(k));
  CHECK_THAT(reading(folder), Contains("a*.obj: found no file for the numbers 30, 40, expected all "
                                       "from 0 to 50 in steps of 10"));
  SequenceOptions gaps;
  gaps.allow_gaps = true;
  CHECK(read_frames(folder, gaps).times == std::vector<double>{0, 10, 20, 50});
  fs::remove(folder / "a50.obj");
  CHECK(read_frames(folder).times == std::vector<double>{0, 10, 20});
  put_bytes(folder / "a100000.obj", triangle(1));
  put_bytes(folder / "a99999.obj", triangle(1));
  CHECK_THAT(reading(folder), Contains("the numbers 1, 2, 3, 4, 5, 6, 7, 8 and 99988 more"));
}

TEST_CASE("names that are no series are refused", "[io][sequences]") {
  const fs::path folder = folder_of("names");
  CHECK_THAT(reading(folder), Contains("found no numbered mesh files in this folder"));
  CHECK_THAT(reading(folder / "a_*.obj"), Contains("a_*.obj: found no such files"));
  CHECK_THAT(reading(folder / "a.obj"), Contains("found no such file"));
  CHECK_THAT(reading(folder / "a.txt"), Contains("expected a folder, a pattern"));
  for (const std::string name : {"a1.obj", "a2.obj", "b1.obj", "b2.obj"})
    put_bytes(folder / name, triangle(1));
  CHECK_THAT(reading(folder), Contains("found 2 series of files, a*.obj, b*.obj; name one"));
  put_bytes(folder / "a01.obj", triangle(1));
  CHECK_THAT(reading(folder / "a*.obj"), Contains("found the number 1 also in a01.obj"));
  put_bytes(folder / "alone.obj", triangle(3));
  CHECK(read_frames(folder / "alone.obj").frame_count() == 1);
}

TEST_CASE("faces that change are refused by the first that differs", "[io][sequences]") {
  const fs::path folder = folder_of("changes");
  const std::string good = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
  put_bytes(folder / "a1.obj", good);
  const auto second = [&](const std::string& text) {
    put_bytes(folder / "a2.obj", text);
    return reading(folder);
  };
  CHECK(second(good).empty());
  CHECK_THAT(second(good + "v 9 9 9\n"),
             Contains("a2.obj: found 5 nodes, expected 4 as in a1.obj"));
  CHECK_THAT(second(good + "f 1 2 4\n"),
             Contains("a2.obj: found 3 faces, expected 2 as in a1.obj"));
  CHECK_THAT(second("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 3 4 1\n"),
             Contains("a2.obj: found face 2 with the nodes 3 4 1, expected 1 3 4 as in a1.obj"));
  CHECK_THAT(second("v 0 0 0\nv 1 nan 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"),
             Contains("a2.obj:2:5: found 'nan'"));
}

TEST_CASE("coordinates that are not finite are named by file and node", "[io][sequences]") {
  const fs::path folder = folder_of("finite");
  const auto binary = [](float z) {
    std::string out =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const float xyz[9] = {0, 0, 0, 1, 0, z, 0, 1, 0};
    out.append(reinterpret_cast<const char*>(xyz), sizeof xyz);
    out += '\3';
    const std::int32_t nodes[3] = {0, 1, 2};
    return out.append(reinterpret_cast<const char*>(nodes), sizeof nodes);
  };
  put_bytes(folder / "a1.ply", binary(0));
  put_bytes(folder / "a2.ply", binary(std::numeric_limits<float>::infinity()));
  CHECK_THAT(reading(folder), Contains("a2.ply") && Contains("node 1") && Contains("finite"));
}

TEST_CASE("STL corners that were one node stay one", "[io][sequences]") {
  const fs::path folder = folder_of("stl");
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0), d(1, 1, 0);
  put_bytes(folder / "s1.stl", stl_text({{a, b, c}, {c, b, d}}));
  const auto second = [&](const std::string& text) {
    put_bytes(folder / "s2.stl", text);
    return reading(folder);
  };
  // Two nodes coincide: alone, this file has three nodes.
  CHECK(second(stl_text({{a, b, c}, {c, b, b}})).empty());
  const MeshSequence s = read_frames(folder);
  CHECK(s.node_count() == 4);
  CHECK(s.frames[1].row(3) == b.transpose());
  // A corner that differs by the rounding of its text.
  CHECK(second(stl_text({{a, b, c}, {c, b + Vec3(1e-6, 0, 0), d}})).empty());
  CHECK_THAT(second(stl_text({{a, b, c}, {c, b + Vec3(1e-5, 0, 0), d}})),
             Contains("s2.stl: node 1 of the first file (s1.stl) has two positions") &&
                 Contains("of triangle 0 and of triangle 1"));
  CHECK_THAT(second(stl_text({{a, b, c}})), Contains("found 1 triangle, expected 2 as in s1.stl"));
}

TEST_CASE("decks are sequences, too", "[io][sequences]") {
  const fs::path folder = folder_of("decks");
  for (const int k : {1, 2})
    put_bytes(folder / ("d" + std::to_string(k) + ".bdf"),
              "GRID,7,,0.,0.," + std::to_string(k) + ".\nGRID,8,,1.,0.,0.\nGRID,9,,0.,1.,0.\n" +
                  "CTRIA3,1,1,7,8,9\nENDDATA\n");
  const MeshSequence s = read_frames(folder);
  CHECK(s.frame_count() == 2);
  CHECK(s.frames[1](0, 2) == 2);
  put_bytes(folder / "d2.bdf",
            "GRID,6,,0.,0.,2.\nGRID,8,,1.,0.,0.\nGRID,9,,0.,1.,0.\nCTRIA3,1,1,6,8,9\nENDDATA\n");
  CHECK_THAT(reading(folder), Contains("d2.bdf: found node 6, expected 7 as in d1.bdf"));
}

TEST_CASE("lists of ParaView are read as they are", "[io][sequences]") {
  const fs::path folder = folder_of("pvd");
  const MeshSequence s = wave(3, 0.5);
  write_sequence(folder / "a b.pvd", s);
  const auto list = [&](const std::string& inside) {
    put_bytes(folder / "l.pvd",
              "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\">\n<Collection>" + inside +
                  "</Collection></VTKFile>\n");
    return reading(folder / "l.pvd");
  };
  CHECK(list("<!-- <DataSet file=\"x\"/> -->"
             "<DataSet\n timestep='2.5' part=\"0\" file='a b/a b_0002.vtp'/>"
             "<DataSet file=\"a b/a b_0003.vtp\" timestep=\"7e0\"></DataSet>")
            .empty());
  const MeshSequence back = read_frames(folder / "l.pvd");
  CHECK(back.times == std::vector<double>{2.5, 7});
  CHECK(back.frames[0] == s.frames[1]);
  CHECK_THAT(list("<DataSet timestep=\"1\" file=\"a b/a b_0001.vtp\"/>"
                  "<DataSet timestep=\"1\" part=\"1\" file=\"a b/a b_0002.vtp\"/>"),
             Contains("found the timestep 1 in <DataSet> 2 after 1, expected ascending timesteps"));
  CHECK_THAT(list("<DataSet timestep=\"x\" file=\"a\"/>"), Contains("found the timestep 'x'"));
  CHECK_THAT(list("<DataSet timestep=\"1\"/>"), Contains("found no file in <DataSet> 1"));
  CHECK_THAT(list("<DataSet timestep=\"1\" "), !Contains("crash"));
  CHECK_THAT(list(""), Contains("found 0 frames"));
  CHECK_THAT(list("<DataSet timestep=\"1\" file=\"none.vtp\"/>"),
             Contains("none.vtp: found no such file"));
  put_bytes(folder / "l.pvd", "text");
  CHECK_THAT(reading(folder / "l.pvd"), Contains("found no <Collection>"));
}

TEST_CASE("damaged point caches are refused with their numbers", "[io][sequences]") {
  const fs::path folder = folder_of("caches");
  const MeshSequence s = wave(3, 1);
  write_sequence(folder / "a.pc2", s);
  write_sequence(folder / "a.mdd", s);
  for (const std::string name : {"a.pc2", "a.mdd"}) {
    INFO(name);
    const fs::path file = folder / name;
    const std::string good = bytes_in(file);
    const size_t counts = name == "a.pc2" ? 16 : 4;
    const auto with = [&](const std::string& bytes) {
      put_bytes(file, bytes);
      return reading(file);
    };
    CHECK(with(good).empty());
    const std::string size = std::to_string(good.size());
    CHECK_THAT(with(good.substr(0, good.size() - 5)),
               Contains("found " + std::to_string(good.size() - 5) + " bytes, expected " + size +
                        " for 3 frames of 11 points"));
    CHECK_THAT(with(good + "x"), Contains("bytes, expected " + size));
    CHECK_THAT(with(good.substr(0, 7)), Contains("found 7 bytes, expected"));
    CHECK_THAT(with(""), Contains("found"));
    std::string bad = good;
    bad[counts + 2] = '\x7f';
    CHECK_THAT(with(bad), Contains("bytes, expected"));
    bad = good;
    for (size_t i = 0; i < 4; ++i) bad[counts + i] = '\xff';
    CHECK_THAT(with(bad), Contains("found 3 frames of -1 points"));
    bad = good;
    for (size_t i = 0; i < 4; ++i) bad[good.size() - 12 * 11 - 4 + i] = '\xff';
    CHECK_THAT(with(bad), Contains("frame 2: a coordinate of point 10 is not finite"));
    put_bytes(file, good);
    SequenceOptions options;
    options.first = options.last = 2;
    const MeshSequence second = read_frames(file, options);
    CHECK(second.frame_count() == 1);
    CHECK(second.times == std::vector<double>{1});
    CHECK((second.frames[0] - s.frames[1]).norm() < 1e-6);
    put_bytes(folder / "small.obj", triangle(1));
    options.mesh = folder / "small.obj";
    CHECK_THAT(reading(file, options),
               Contains("found 11 points in each frame, expected 3 as the mesh"));
    fs::remove(folder / "small.obj");
  }
  std::string bad = bytes_in(folder / "a.pc2");
  bad[0] = 'Q';
  put_bytes(folder / "a.pc2", bad);
  CHECK_THAT(reading(folder / "a.pc2"), Contains("found 'QOINTCACHE2?', expected 'POINTCACHE2'"));
  bad[0] = 'P';
  bad[12] = 2;
  put_bytes(folder / "a.pc2", bad);
  CHECK_THAT(reading(folder / "a.pc2"), Contains("found version 2 of POINTCACHE2, expected 1"));
  bad[12] = 1;
  bad[27] = 0;
  bad[26] = 0;
  put_bytes(folder / "a.pc2", bad);
  CHECK_THAT(reading(folder / "a.pc2"), Contains("the rate 0, expected a rate above 0"));
}

TEST_CASE("the mesh of a point cache is found beside it", "[io][sequences]") {
  const fs::path folder = folder_of("beside");
  const MeshSequence s = wave(2, 1);
  write_sequence(folder / "a.pc2", s);
  fs::rename(folder / "a.obj", folder / "mesh.obj");
  CHECK(read_frames(folder / "a.pc2").frame_count() == 2);  // the only one
  put_bytes(folder / "small.obj", triangle(1));
  CHECK_THAT(reading(folder / "a.pc2"), Contains("found 2 mesh files next to this point cache"));
  fs::rename(folder / "mesh.obj", folder / "a_03.obj");
  put_bytes(folder / "a_12.obj", triangle(1));
  CHECK(read_frames(folder / "a.pc2").frame_count() == 2);  // the first numbered one
  fs::rename(folder / "a_03.obj", folder / "a.obj");
  CHECK(read_frames(folder / "a.pc2").frame_count() == 2);
}

TEST_CASE("sequences are stopped by their caller", "[io][sequences]") {
  const fs::path folder = folder_of("stop");
  write_sequence(folder / "a_*.obj", wave(3));
  write_sequence(folder / "a.pc2", wave(3));
  write_sequence(folder / "a.glb", wave(3));
  for (const fs::path& path : {folder / "a_*.obj", folder / "a.pc2", folder / "a.glb"}) {
    int asked = 0;
    Progress progress;
    progress.cancelled = [&] { return ++asked == 3; };
    CHECK_THROWS_AS(read_frames(path, {}, progress), CancelledError);
  }
}

TEST_CASE("caches and files of real sequences agree", "[io][sequences]") {
  int read = 0;
  for (const std::string clip : {"walk", "run", "survey"}) {
    const fs::path folder = optional_data("seq-fox/" + clip);
    if (folder.empty()) continue;
    const MeshSequence files = read_frames(folder),
                       cache = read_frames(folder / ("fox_" + clip + ".pc2"));
    CHECK(files.node_count() == 290);
    CHECK(files.shells.face_count() == 576);
    CHECK(files.frame_count() == (clip == "survey" ? 40 : 24));
    CHECK(apart(files, cache) < 1e-7 * size_of(files));
    ++read;
  }
  if (const fs::path can = optional_data("seq-can-crush"); !can.empty()) {
    const MeshSequence files = read_frames(can);
    CHECK(files.frame_count() == 3);
    CHECK(files.node_count() == 3682);
    CHECK(apart(files, read_frames(can / "can.pc2")) < 1e-6 * size_of(files));
    ++read;
  }
  if (const fs::path cloth = optional_data("seq-cloth-ball"); !cloth.empty()) {
    const MeshSequence s = read_frames(cloth);
    CHECK(s.times == std::vector<double>{92, 93});
    CHECK(s.node_count() == 46598);
    ++read;
  }
  if (read == 0) WARN("no real sequences beside the project: skipped");
}
