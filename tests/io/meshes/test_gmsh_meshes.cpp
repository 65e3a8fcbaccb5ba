// SPDX-License-Identifier: MPL-2.0
// Gmsh's text formats: sets from physical groups, and coordinates that are replaced in the text.
#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

// A quad beside a triangle, with an edge that both a curve and a hanging line mark.
const std::string kEntities =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n3\n1 5 \"left edge\"\n2 7 \"sheet\"\n2 8 \"corner\"\n$EndPhysicalNames\n"
    "$Entities\n0 1 2 0\n1 0 0 0 0 1 0 1 -5 0 \n"
    "3 0 0 0 1 1 0 1 7 1 1 \n4 1 0 0 2 1 0 2 7 8 0 \n$EndEntities\n";
const std::string kBlocks =
    "$Nodes\n2 6 1 60\n1 1 0 2\n1\n4\n0 0 0\n0 1 0\n"
    "2 3 1 4\n2\n3\n50\n60\n1 0 0 0.5 0.5\n1 1 0 0 0\n2 0.5 0 0 0\n9 9 9 0 0\n$EndNodes\n"
    "$Elements\n4 4 1 9\n1 1 1 1\n1 4 1 \n2 3 3 1\n2 1 2 3 4 \n2 4 2 1\n9 2 50 3 \n"
    "1 2 1 1\n5 50 60\n$EndElements\n";

// The same in version 2.2, where an element in two groups is written twice.
const std::string kList =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n3\n1 5 \"left edge\"\n2 7 \"sheet\"\n2 8 \"corner\"\n$EndPhysicalNames\n"
    "$Nodes\n6\n1 0 0 0\n4 0 1 0\n2 1 0 0\n3 1 1 0\n50 2 0.5 0\n60 9 9 9\n$EndNodes\n"
    "$Elements\n5\n1 1 2 5 1 4 1\n2 3 2 7 3 1 2 3 4\n9 2 2 7 4 2 50 3\n10 2 2 8 4 2 50 3\n"
    "5 1 2 0 2 50 60\n$EndElements\n";

const MeshSet& set_called(const MeshFile& file, const std::string& name) {
  for (const MeshSet& set : file.sets())
    if (set.name == name) return set;
  FAIL("no set " << name);
  return file.sets().front();
}

}  // namespace

TEST_CASE("versions 2.2 and 4.1 of Gmsh's format describe the same mesh", "[io][decks]") {
  for (const std::string& text : {kEntities + kBlocks, kList}) {
    const MeshFile file = MeshFile::read(file_with("two.msh", text));
    REQUIRE(file.shells().face_count() == 2);
    REQUIRE(file.shells().node_count() == 6);
    CHECK(file.face_label(1) == 9);
    CHECK(file.shells().corners(1).size() == 3);
    CHECK(set_called(file, "sheet").faces == std::vector<int>{0, 1});
    CHECK(set_called(file, "corner").faces == std::vector<int>{1});
    CHECK(set_called(file, "left edge").nodes.size() == 2);
    REQUIRE(file.properties().size() == 2);
    CHECK(file.properties()[0].name == "3");
    // The line along the sheet only marks its edge; the other one is a connection.
    REQUIRE(file.other_elements().size() == 1);
    CHECK(file.other_elements()[0].label == 5);

    Points moved = file.shells().points;
    moved(4, 2) = 0.125;
    const std::filesystem::path path = file_with("two.msh", text).parent_path() / "moved.msh";
    file.write(path, moved);
    const std::string written = bytes_of(path);
    std::string expected = text;
    const std::string before = "2 0.5 0", after = "2 0.5 0.125";
    expected.replace(expected.find(before), before.size(), after);
    CHECK(written == expected);
  }
}

TEST_CASE("second-order elements of Gmsh keep their mid-side nodes", "[io][decks]") {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n";
  const double x[9] = {0, 2, 2, 0, 1, 2, 1, 0, 1}, y[9] = {0, 0, 2, 2, 0, 1, 2, 1, 1};
  for (int i = 0; i < 9; ++i)
    text +=
        std::to_string(i + 1) + " " + std::to_string(x[i]) + " " + std::to_string(y[i]) + " 0\n";
  const auto with = [&](const std::string& element) {
    return MeshFile::read(
        file_with("second.msh", text + "$EndNodes\n$Elements\n1\n" + element + "\n$EndElements\n"));
  };
  const MeshFile eight = with("1 16 2 0 1 1 2 3 4 5 6 7 8"),
                 nine = with("1 10 2 0 1 1 2 3 4 5 6 7 8 9"), six = with("1 9 2 0 1 1 2 3 5 6 9");
  CHECK(eight.shells().face(0).size() == 8);
  CHECK(eight.shells().corners(0).size() == 4);
  CHECK(six.shells().corners(0).size() == 3);
  CHECK(nine.shells().face(0).size() == 8);
  REQUIRE(nine.other_elements().size() == 1);
  CHECK(nine.other_elements()[0].nodes.front() == 8);
  CHECK_THROWS_WITH(with("1 21 2 0 1 1 2 3"), Contains("second.msh:18:3: found element type '21'"));
}

TEST_CASE("damaged Gmsh files are refused with their location", "[io][decks]") {
  const auto error = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return read_error("damaged.msh", text);
  };
  CHECK_THAT(error(kList, "3 1 1 0", "3 1 x 0"), StartsWith("15:5: found 'x', expected a number"));
  CHECK_THAT(error(kList, "2 50 3\n10", "2 51 3\n10"), Contains("found node 51 in element 9"));
  CHECK_THAT(error(kEntities + kBlocks, "5 50 60\n$EndElements\n", ""),
             Contains("end of the file"));
  CHECK_THAT(error(kEntities + kBlocks, "$Elements\n4 4", "$Elements\n4000000000 4"),
             Contains("expected"));
  // Gmsh executes text that is no mesh as a script.
  CHECK_THAT(error(kList, "$MeshFormat", "SystemCall \"touch x\";"),
             Contains("expected a Gmsh mesh"));
}

TEST_CASE("a missing gmsh is named, and damaged binary files are refused", "[io][decks]") {
  const std::string binary = "$MeshFormat\n4.1 1 8\n\1";
  setenv("GMSH", "/no/such/gmsh", 1);
  CHECK_THAT(read_error("binary.msh", binary),
             Contains("found no program '/no/such/gmsh', expected Gmsh (package gmsh)"));
  unsetenv("GMSH");
  if (std::system("command -v gmsh > /dev/null") != 0) {
    WARN("no gmsh here: skipped");
    return;
  }
  CHECK_THAT(read_error("binary.msh", binary), Contains("Gmsh cannot convert this file"));
}

TEST_CASE("Gmsh reads its own files after an edit: all formats, moved nodes, the same groups",
          "[io][decks]") {
  if (!have_python_with("gmsh") || std::system("command -v gmsh > /dev/null") != 0) return;
  const std::filesystem::path folder = scratch("gmsh_formats"), out = scratch("gmsh_formats_out");
  const std::string script =
      "/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/meshes/gmsh_meshes.py' ";
  REQUIRE(std::system((script + "write '" + folder.string() + "'").c_str()) == 0);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    INFO(name);
    const MeshFile file = MeshFile::read(entry.path());
    // Version 1 has no names.
    const bool has_names = name.find("version10") == name.npos;
    const MeshSet* hole = nullptr;
    for (const MeshSet& set : file.sets())
      if (set.name == "hole" || (!has_names && !set.nodes.empty())) hole = &set;
    REQUIRE(hole);
    for (const int node : hole->nodes)
      CHECK((file.shells().points.row(node) - Vec3(30, 25, 0).transpose()).norm() ==
            Approx(10).epsilon(0.02));
    CHECK(file.shells().second_order(0) == (name.find("order2") == 0));
    // Without an edit, no byte changes.
    file.write(out / name, file.shells().points);
    CHECK(bytes_of(out / name) == bytes_of(entry.path()));
    Points moved = file.shells().points;
    for (int i = 0; i < moved.rows(); ++i) moved(i, 2) = 0.25 * moved(i, 0) + 1.0 / 3;
    file.write(out / name, moved);
    const auto read = positions_from(other_reader("gmsh", out / name));
    CHECK(isize(read) >= file.shells().node_count());
    for (int i = 0; i < moved.rows(); ++i)
      if (const auto found = read.find(file.node_label(i)); found != read.end())
        CHECK((found->second - moved.row(i).transpose()).norm() < 1e-12);
    const auto groups = [&](const std::filesystem::path& path) {
      std::string text;
      FILE* const pipe = popen((script + "groups '" + path.string() + "'").c_str(), "r");
      REQUIRE(pipe);
      for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
      pclose(pipe);
      return text;
    };
    const std::string before = groups(entry.path());
    CHECK(before == groups(out / name));
    CHECK(std::count(before.begin(), before.end(), '\n') == 3);
    ++files;
  }
  CHECK(files == 14);
}
