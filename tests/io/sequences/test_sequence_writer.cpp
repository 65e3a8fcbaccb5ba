// SPDX-License-Identifier: MPL-2.0
// Written sequences are read back, by our readers and by those of other programs.
#include <vtkCellArray.h>
#include <vtkCompositeDataIterator.h>
#include <vtkGLTFReader.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkXMLPolyDataReader.h>

#include "batten/tests/io/sequences/sequence_file_helpers.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

fs::path writer_folder(const std::string& name) { return scratch("sequence_writer/" + name); }

Points points_of(vtkPointSet* data) {
  Points points(data->GetNumberOfPoints(), 3);
  for (int i = 0; i < points.rows(); ++i)
    for (int c = 0; c < 3; ++c) points(i, c) = data->GetPoint(i)[c];
  return points;
}

}  // namespace

TEST_CASE("numbered files come back bit by bit", "[io][sequences]") {
  const MeshSequence s = wave(4, 1);
  for (const std::string extension : {".obj", ".ply", ".off", ".vtp", ".vtu"}) {
    INFO(extension);
    const fs::path folder = writer_folder("numbered");
    write_sequence(folder / ("a_*" + extension), s);
    CHECK(names_in(folder) == std::set<std::string>{"a_0000" + extension, "a_0001" + extension,
                                                    "a_0002" + extension, "a_0003" + extension});
    const MeshSequence back = read_frames(folder / ("a_*" + extension));
    CHECK(apart(s, back) == 0);
    CHECK(back.times == s.times);
    CHECK(faces_of(back.shells) == faces_of(s.shells));
    CHECK(back.shells.points == s.frames.front());
  }
}

TEST_CASE("STL frames keep their triangles", "[io][sequences]") {
  // The shorter diagonal of a quad changes from frame to frame.
  MeshSequence s = wave(3);
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < s.node_count(); ++i) s.frames[k](i, 0) += (k - 1) * s.frames[k](i, 1);
  const fs::path folder = writer_folder("stl");
  write_sequence(folder / "a_%02d.stl", s);
  const MeshSequence back = read_frames(folder);
  REQUIRE(back.node_count() == s.node_count());
  CHECK(back.shells.face_count() == 3 * 2 + 3 + 1);
  CHECK(back.times == std::vector<double>{1, 2, 3});
  // Nodes are renumbered: each one corresponds to one node of all frames.
  for (int i = 0; i < s.node_count(); ++i) {
    int same = -1;
    for (int j = 0; j < s.node_count(); ++j)
      if ((s.frames[0].row(i) - back.frames[0].row(j)).norm() < 1e-6) same = j;
    REQUIRE(same >= 0);
    for (int k = 0; k < 3; ++k)
      CHECK((s.frames[k].row(i) - back.frames[k].row(same)).norm() < 1e-6);
  }
  for (int k = 0; k < 3; ++k) {
    vtkNew<vtkSTLReader> reader;
    reader->SetFileName((folder / ("a_0" + std::to_string(k + 1) + ".stl")).c_str());
    reader->Update();
    CHECK(reader->GetOutput()->GetNumberOfPolys() == back.shells.face_count());
    CHECK(reader->GetOutput()->GetNumberOfPoints() == s.node_count());
  }
}

TEST_CASE("a folder gets numbered OBJ files that VTK reads", "[io][sequences]") {
  const MeshSequence s = wave(3);
  const fs::path folder = writer_folder("plain") / "new";
  write_sequence(folder, s);
  CHECK(names_in(folder) ==
        std::set<std::string>{"frame_0001.obj", "frame_0002.obj", "frame_0003.obj"});
  for (int k = 0; k < 3; ++k) {
    vtkNew<vtkOBJReader> reader;
    reader->SetFileName((folder / ("frame_000" + std::to_string(k + 1) + ".obj")).c_str());
    reader->Update();
    CHECK((points_of(reader->GetOutput()) - s.frames[k]).norm() < 1e-6);
    CHECK(reader->GetOutput()->GetNumberOfPolys() == s.shells.face_count());
  }
  CHECK(apart(read_frames(folder), s) == 0);
  CHECK(apart(read_frames(folder / "frame_0002.obj"), s) == 0);
}

TEST_CASE("ParaView's list has the times", "[io][sequences]") {
  const MeshSequence s = wave(3, 0.04);
  const fs::path folder = writer_folder("pvd");
  write_sequence(folder / "run.pvd", s);
  CHECK(names_in(folder) == std::set<std::string>{"run", "run.pvd"});
  CHECK(names_in(folder / "run") ==
        std::set<std::string>{"run_0001.vtp", "run_0002.vtp", "run_0003.vtp"});
  const MeshSequence back = read_frames(folder / "run.pvd");
  CHECK(apart(back, s) == 0);
  CHECK(back.times == s.times);
  CHECK(faces_of(back.shells) == faces_of(s.shells));
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((folder / "run/run_0002.vtp").c_str());
  reader->Update();
  CHECK(points_of(reader->GetOutput()) == s.frames[1]);
}

TEST_CASE("point caches comply with their formats", "[io][sequences]") {
  const MeshSequence s = wave(3, 0.25);
  const fs::path folder = writer_folder("caches");
  const int n = s.node_count();
  write_sequence(folder / "a.pc2", s);
  const std::string pc2 = bytes_in(folder / "a.pc2");
  REQUIRE(pc2.size() == size_t(32 + 12 * n * 3));
  CHECK(pc2.substr(0, 12) == std::string("POINTCACHE2\0", 12));
  CHECK(number_in<std::int32_t>(pc2, 12) == 1);
  CHECK(number_in<std::int32_t>(pc2, 16) == n);
  CHECK(number_in<float>(pc2, 20) == 0.f);
  CHECK(number_in<float>(pc2, 24) == 0.25f);
  CHECK(number_in<std::int32_t>(pc2, 28) == 3);
  MeshSequence uneven = s;
  uneven.times = {0, 1, 5};
  write_sequence(folder / "b.mdd", uneven);
  const std::string mdd = bytes_in(folder / "b.mdd");
  REQUIRE(mdd.size() == size_t(8 + 4 * 3 + 12 * n * 3));
  CHECK(number_in<std::int32_t>(mdd, 0, true) == 3);
  CHECK(number_in<std::int32_t>(mdd, 4, true) == n);
  CHECK(number_in<float>(mdd, 16, true) == 5.f);
  for (size_t k = 0; k < 3; ++k)
    for (size_t i = 0; i < size_t(n); ++i)
      for (size_t c = 0; c < 3; ++c) {
        const auto value = float(s.frames[k](int(i), int(c)));
        CHECK(number_in<float>(pc2, 32 + 12 * (k * size_t(n) + i) + 4 * c) == value);
        CHECK(number_in<float>(mdd, 20 + 12 * (k * size_t(n) + i) + 4 * c, true) == value);
      }
  for (const std::string name : {"a.pc2", "b.mdd"}) {
    const MeshSequence back = read_frames(folder / name);
    for (int k = 0; k < 3; ++k) CHECK(back.frames[k] == s.frames[k].cast<float>().cast<double>());
    CHECK(back.times == (name == "a.pc2" ? s.times : uneven.times));
    CHECK(faces_of(back.shells) == faces_of(s.shells));
  }
  CHECK_THAT(error_message([&] { write_sequence(folder / "c.pc2", uneven); }),
             Contains("found the time 1 of frame 2, expected uniform times"));
  CHECK(names_in(folder) == std::set<std::string>{"a.obj", "a.pc2", "b.mdd", "b.obj"});
}

TEST_CASE("GLB files come back and move in VTK", "[io][sequences]") {
  const MeshSequence s = wave(5, 0.5);
  const fs::path file = writer_folder("glb") / "a.glb";
  write_sequence(file, s);
  SequenceOptions keys;
  keys.frames_per_second = 0;
  const MeshSequence back = read_frames(file, keys);
  CHECK(apart(back, s) < 2e-7 * size_of(s));
  CHECK(back.times == s.times);
  CHECK(back.shells.face_count() == 3 * 2 + 3 + 1);
  // Interpolated between frames.
  SequenceOptions between;
  between.frames_per_second = 4;
  const MeshSequence finer = read_frames(file, between);
  REQUIRE(finer.frame_count() == 9);
  for (int k = 0; k < 4; ++k)
    CHECK((finer.frames[2 * k + 1] - (s.frames[k] + s.frames[k + 1]) / 2).norm() < 1e-6);

  vtkNew<vtkGLTFReader> reader;
  reader->SetFileName(file.c_str());
  reader->SetApplyDeformationsToGeometry(true);
  reader->UpdateInformation();
  REQUIRE(reader->GetNumberOfAnimations() == 1);
  CHECK(reader->GetAnimationDuration(0) == Approx(2));
  reader->EnableAnimation(0);
  reader->SetFrameRate(2);
  reader->UpdateInformation();
  for (int k = 0; k < 5; ++k) {
    reader->UpdateTimeStep(s.times[k]);
    auto* const iterator = reader->GetOutput()->NewIterator();
    iterator->InitTraversal();
    REQUIRE(!iterator->IsDoneWithTraversal());
    auto* const data = vtkPolyData::SafeDownCast(iterator->GetCurrentDataObject());
    REQUIRE(data);
    CHECK((points_of(data) - s.frames[k]).rowwise().norm().maxCoeff() < 2e-7 * size_of(s));
    CHECK(data->GetNumberOfCells() == back.shells.face_count());
    iterator->Delete();
  }
}

TEST_CASE("one frame is a scene that stands still", "[io][sequences]") {
  const MeshSequence s = wave(1);
  const fs::path folder = writer_folder("one");
  for (const std::string name : {"a.glb", "a.pc2", "a.mdd", "a.pvd", "a_*.obj"}) {
    write_sequence(folder / name, s);
    CHECK(apart(read_frames(folder / name), s) < 1e-6);
  }
}

TEST_CASE("single files appear whole or not at all", "[io][sequences]") {
  const MeshSequence s = wave(3);
  for (const std::string name : {"a.glb", "a.pc2", "a.mdd"}) {
    const fs::path folder = writer_folder("whole");
    {
      SequenceWriter writer(folder / name, s.shells, s.times);
      writer.write(0, s.frames[0]);
      CHECK(!writer.has(0));
      CHECK(writer.file(1) == folder / name);
      CHECK(!fs::exists(folder / name));
      CHECK_THROWS_AS(writer.finish(), std::logic_error);
      CHECK_THROWS_AS(writer.write(2, s.frames[2]), std::logic_error);
    }
    CHECK(names_in(folder).empty());
  }
}

TEST_CASE("a run that was stopped goes on where it was", "[io][sequences]") {
  const MeshSequence s = wave(4);
  const fs::path folder = writer_folder("resume");
  {
    SequenceWriter writer(folder / "a_*.off", s.shells, s.times);
    writer.write(0, s.frames[0]);
    writer.write(1, s.frames[1]);
  }
  SequenceWriter again(folder / "a_*.off", s.shells, s.times);
  std::vector<int> written;
  for (int k = 0; k < 4; ++k)
    if (!again.has(k)) {
      written.push_back(k);
      again.write(k, s.frames[k]);
    }
  again.finish();
  CHECK(written == std::vector<int>{2, 3});
  CHECK(apart(read_frames(folder), s) == 0);
  CHECK(again.files().size() == 4);
}

TEST_CASE("several runs share the frames of numbered files", "[io][sequences]") {
  const MeshSequence s = wave(4);
  const fs::path folder = writer_folder("shared");
  SequenceWriter second(folder / "a_*.off", s.shells, s.times);
  for (int k = 2; k < 4; ++k) second.write(k, s.frames[k]);
  CHECK_THROWS_AS(second.finish(), std::logic_error);
  SequenceWriter first(folder / "a_*.off", s.shells, s.times);
  for (int k = 0; k < 2; ++k) first.write(k, s.frames[k]);
  second.finish();
  CHECK(apart(read_frames(folder), s) == 0);
}

TEST_CASE("writers refuse data that they cannot write", "[io][sequences]") {
  const MeshSequence s = wave(2);
  const fs::path folder = writer_folder("refused");
  const auto writing = [&](const std::string& name) {
    return error_message([&] { write_sequence(folder / name, s); });
  };
  CHECK_THAT(writing("a.obj"),
             Contains("found one file for all frames, expected a pattern for their "
                      "numbers, such as a_*.obj"));
  CHECK_THAT(writing("a.gltf"), Contains("found the extension '.gltf', expected"));
  CHECK_THAT(writing("a_*.bdf"), Contains("found numbered files '.bdf', expected .obj"));
  CHECK_THAT(writing("a_*_*.obj"), Contains("found several patterns for a number"));
  CHECK_THAT(writing("a_%s.obj"), Contains("expected one * or %04d"));
  CHECK_THAT(writing("no/where/a_*.obj"), Contains("cannot create this folder"));
  const auto refused = [&](const std::string& name, auto change) {
    MeshSequence bad = s;
    change(bad);
    return error_message([&] { write_sequence(folder / name, bad); });
  };
  CHECK_THAT(refused("b_*.obj",
                     [](MeshSequence& b) {
                       b.times = {1, 1};
                     }),
             Contains("found the time 1 of frame 2, expected ascending ones"));
  CHECK_THAT(refused("b_*.obj", [](MeshSequence& b) { b.frames[1](3, 1) = NAN; }),
             Contains("frame 2: a coordinate of node 3 is not finite"));
  for (const std::string name : {"b.pc2", "b.mdd", "b.glb", "b_*.stl"})
    CHECK_THAT(refused(name, [](MeshSequence& b) { b.frames[1](3, 1) = 1e39; }),
               Contains("too large for single precision"));
  CHECK_THAT(refused("b_*.obj", [](MeshSequence& b) { b.frames[1].conservativeResize(4, 3); }),
             Contains("found 4 points, expected 11"));
}
