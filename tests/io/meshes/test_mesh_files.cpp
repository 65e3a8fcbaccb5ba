// SPDX-License-Identifier: MPL-2.0
// Mesh files are written back unchanged, and other programs read the same content.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "batten/io/files/atomic_file.h"
#include "batten/tests/io/meshes/mesh_file_properties.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string kObj =
    "# a box, v 1 2 3\n"
    "mtllib box.mtl\n"
    "v 0 0 0\n"
    "v  1.0\t0.0 0.0 1.0\n"
    "v 1 1 0 0.5 0.5 0.5\n"
    "\n"
    "v 0 1 \\\n"
    "  0.5e0\n"
    "vt 0 0\n"
    "vn 0 0 1\n"
    "o part one\n"
    "g left all\n"
    "usemtl steel\n"
    "f 1 2 3 4 # a quad\n"
    "g right all\n"
    "v 2 0 0\n"
    "v 2 1 0\n"
    "f -2/1/1 -1//1 \\\n"
    "  3/1 2\n"
    "l 1 2\n"
    "v 9 9 9\n"
    "usemtl brass\n"
    "f 1 2 7";

const std::string kOff =
    "COFF # header\n"
    "# comment 1 2 3\n"
    "5 2 0\n"
    "0 0 0  255 0 0 255\n"
    "1.000 0 -0.0  0 255 0 255\n"
    "\n"
    "  1 1 0\n"
    "0 1 0 # last\n"
    "0.5 0.5 1e-3\n"
    "4 0 1 2 3 0.5 0.5 0.5\n"
    "3 0 1 4\n"
    "more text\n";

const std::string kPly =
    "ply\nformat ascii 1.0\ncomment float x\nelement vertex 4\nproperty double y\n"
    "property uchar red\nproperty double x\nproperty float z\nproperty float nx\n"
    "element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\n"
    "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    "0 255 0.10 0 1\n0 254 1 0 1\n1 253 1 0 1\n1 252 0 0.25 1\n7 3 0 1 2\n8 3 0 2 3\n0 1\n";

template <class T>
void put(std::string& out, T value, bool big) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if (big) std::reverse(bytes, bytes + sizeof value);
  out.append(bytes, sizeof value);
}

/// A square of two triangles with colours, coordinates of type T.
template <class T>
std::string binary_ply(bool big) {
  const std::string type = sizeof(T) == 4 ? "float" : "double";
  std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex 4\nproperty uchar red\nproperty " + type +
                    " x\nproperty " + type + " y\nproperty " + type +
                    " z\nelement face 2\nproperty list uchar uint vertex_index\nproperty short "
                    "flag\nend_header\n";
  const T places[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, T(0.25)}};
  for (const auto& place : places) {
    out += 'r';
    for (const T x : place) put(out, x, big);
  }
  for (const auto& face : {std::array<int, 3>{0, 1, 2}, std::array<int, 3>{0, 2, 3}}) {
    out += '\3';
    for (const int node : face) put(out, node, big);
    put(out, short{-7}, big);
  }
  return out + "after the end";
}

const std::string kStl =
    "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1.00 0 0\n"
    "   vertex 1 1 0\n  endloop\n endfacet\nendsolid one\nsolid two\n facet normal 0 0 1\n"
    "  outer loop\n   vertex 0 0 -0.0\n   vertex 1e0 1 0\n   vertex 0 1 0\n  endloop\n"
    " endfacet\nendsolid two\n";

/// Faces with three, four, six and eight nodes side by side.
ShellMesh mixed_mesh() {
  ShellMesh mesh;
  mesh.points.resize(17, 3);
  for (int i = 0; i < 17; ++i) mesh.points.row(i) << i / 3.0, std::sin(i), std::cos(1.7 * i) / 7;
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{1, 3, 4, 2});
  mesh.add_face(std::array{3, 5, 4, 6, 7, 8}, true);
  mesh.add_face(std::array{5, 9, 10, 4, 11, 12, 13, 7}, true);
  mesh.add_face(std::array{10, 9, 14, 15, 16});
  return mesh;
}

void check_positions(const fs::path& path, const Points& points, double tolerance) {
  const auto positions = positions_from(other_reader("vtk", path));
  INFO(path.string());
  REQUIRE(positions.size() == static_cast<size_t>(points.rows()));
  double largest = 0;
  for (const auto& [i, place] : positions)
    largest = std::max(largest, (points.row(i).transpose() - place).cwiseAbs().maxCoeff());
  CHECK(largest <= tolerance);
}

}  // namespace

TEST_CASE("OBJ: nodes, faces, groups, materials", "[io][meshes]") {
  const MeshFile file = MeshFile::read(file_with("box.obj", kObj));
  REQUIRE(file.shells().node_count() == 7);
  REQUIRE(file.shells().face_count() == 3);
  CHECK(file.shells().points.row(3) == Points(Vec3(0, 1, 0.5).transpose()).row(0));
  const auto face = file.shells().face(1);
  CHECK(std::vector<int>(face.begin(), face.end()) == std::vector<int>{4, 5, 2, 1});
  CHECK(file.node_label(0) == 1);
  CHECK(file.face_of_label(2) == 1);
  CHECK_FALSE(file.node_of_label(0));
  CHECK_FALSE(file.node_of_label(8));
  std::map<std::string, std::vector<int>> sets;
  for (const auto& set : file.sets()) sets[set.name] = set.faces;
  CHECK(sets == std::map<std::string, std::vector<int>>{
                    {"part one", {0, 1, 2}}, {"left", {0}}, {"right", {1, 2}}, {"all", {0, 1, 2}}});
  REQUIRE(file.properties().size() == 2);
  CHECK(file.properties()[0].name == "steel");
  CHECK(file.properties()[0].faces == std::vector<int>{0, 1});
  REQUIRE(file.warnings().size() == 3);
  CHECK_THAT(file.warnings()[0], Contains("1 normal (vn)"));
  CHECK_THAT(file.warnings()[2], Contains("no line end"));
}

TEST_CASE("unchanged nodes keep every byte of a text file", "[io][meshes]") {
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"i.obj", kObj},
                                   {"i.off", kOff},
                                   {"i.stl", kStl},
                                   {"i.ply", kPly}}) {
    check_identity(file_with(name, text));
    check_identity(file_with(name, with_carriage_returns(text)));
  }
  check_identity(file_with("bom.obj", "\xEF\xBB\xBF" + kObj));
  check_identity(file_with("latin.obj",
                           "# gr\xFC\xDF"
                           "e\n" +
                               kObj));
}

TEST_CASE("free text takes every digit, and only coordinates change", "[io][meshes]") {
  // Differing tokens must be coordinates.
  const auto check = [](const std::string& name, const std::string& text, auto&& is_coordinate) {
    const auto path = file_with(name, text);
    const MeshFile file = MeshFile::read(path);
    const auto target = check_round_trip(path, moved(file, 0.3, 1), 0);
    const auto before = lines_of(text), after = lines_of(bytes_of(target));
    REQUIRE(before.size() == after.size());
    for (size_t i = 0; i < before.size(); ++i) {
      std::istringstream a(before[i]), b(after[i]);
      std::string x, y;
      for (int token = 0; a >> x; ++token) {
        REQUIRE(b >> y);
        INFO(before[i] << " became " << after[i]);
        CHECK((x == y || is_coordinate(before[i], token)));
      }
      CHECK_FALSE(b >> y);
    }
  };
  check("w.obj", kObj, [](const std::string& line, int token) {
    return (line.starts_with("v ") && token >= 1 && token <= 3) || line == "  0.5e0";
  });
  check("w.off", kOff, [](const std::string& line, int token) {
    return !line.starts_with("#") && line.find("OFF") == line.npos && token < 3;
  });
  check("w.ply", kPly,
        [](const std::string&, int token) { return token == 0 || token == 2 || token == 3; });
  check("w.stl", kStl, [](const std::string& line, int token) {
    return (line.find("vertex") < line.npos && token > 0) ||
           (line.find("normal") < line.npos && token > 1);
  });
  // One coordinate of one node: one token.
  const auto path = file_with("one.obj", kObj);
  Points points = MeshFile::read(path).shells().points;
  points(1, 1) = 0.1;
  std::string expected = kObj;
  expected.replace(expected.find("\t0.0"), 4, "\t0.1");
  CHECK(bytes_of(check_round_trip(path, points, 0)) == expected);
}

TEST_CASE("OFF: headers and counts", "[io][meshes]") {
  const std::string body = "0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2\n";
  for (const std::string header : {"OFF\n3 1 0\n", "OFF 3 1 0\n", "NOFF\n3 1\n", "STCNOFF 3 1 3\n",
                                   "# x\n\nOFF\n# y\n3 1 0 # z\n", "3 1 0\n"}) {
    const MeshFile file = MeshFile::read(file_with("h.off", header + body));
    CHECK(file.shells().points.col(0).sum() == 1);
    CHECK(file.node_label(2) == 2);
    CHECK(file.warnings().size() == (header.find("NOFF") < header.npos ? 1 : 0));
  }
  const auto says = [](const std::string& text) { return read_error("e.off", text); };
  CHECK(says("4OFF\n3 1 0\n") == "1:1: found '4OFF', expected OFF, COFF, NOFF, STOFF or CNOFF");
  CHECK(says("OFF BINARY\n") == "1:5: found a binary OFF file, expected text");
  CHECK(says("OFF\n4 1 0\n" + body) == "7:1: found 0 faces, expected 1");
  CHECK(says("OFF\n3 2 0\n" + body) == "7:1: found 1 face, expected 2");
  CHECK(says("OFF\n9999999999999 2 0\n") ==
        "2:1: found '9999999999999 2 0', expected numbers of nodes and faces");
  CHECK(says("OFF\n2000000000 2 0\n0 0 0\n") == "4:1: found 1 node, expected 2000000000");
  CHECK(says("OFF\n1 1 0\n0 0\n") == "3:1: found 2 numbers, expected the 3 coordinates of node 0");
  CHECK(says("OFF\n1 1 0\n0 0 0\n3 0 0 1\n") == "4:7: found node number '1', expected 0 to 0");
  CHECK(says("OFF\n1 1 0\n0 0 0\n2 0 0\n") == "4:1: found a face of 2 nodes, expected 3 or more");
  CHECK(says("OFF\n1 1 0\n0 0 0\n4 0 0 0\n") ==
        "4:1: found a face of 3 nodes, expected 4 as stated");
  CHECK(says("OFF\n") == "2:1: found the end of the file, expected the numbers of nodes and faces");
  CHECK(says("ply\n") == "1:1: found 'ply', expected 'OFF'");
}

TEST_CASE("OBJ: errors are reported with line and column", "[io][meshes]") {
  const auto says = [](const std::string& text) { return read_error("e.obj", text); };
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK(says(v + "f 1 2 4\n") == "4:7: found node number 4, expected 1 to 3 or -1 to -3");
  CHECK(says(v + "f 0 1 2\n") == "4:3: found node number 0, expected 1 to 3 or -1 to -3");
  CHECK(says(v + "f 1 2 -4\n") == "4:7: found node number -4, expected 1 to 3 or -1 to -3");
  CHECK(says(v + "f 1 2 99999999999\n") ==
        "4:7: found node number 99999999999, expected 1 to 3 or -1 to -3");
  CHECK(says(v + "f 1 2\n") == "4:1: found a face of 2 nodes, expected 3 or more");
  CHECK(says(v + "f 1 2 x\n") == "4:7: found 'x', expected a node number");
  CHECK(says("v 0 0\n") == "1:6: found 2 coordinates, expected 3 (v x y z)");
  CHECK(says("v 0 0 nan\n") == "1:7: found 'nan', expected a finite number");
  CHECK(says("v 0 -inf 0\n") == "1:5: found '-inf', expected a finite number");
  CHECK(says("v 0 0 1e999\n") == "1:7: found '1e999', expected a number between 1e-307 and 1e308");
  CHECK(says(v) == " found 3 nodes but no faces, expected at least one");
  CHECK(says("f 1 2 3\n") == "2:1: found no nodes, expected records 'v x y z'");
  // Nodes may follow the faces.
  CHECK(MeshFile::read(file_with("later.obj", "f 1 2 3\n" + v)).shells().face_count() == 1);
}

TEST_CASE("files that are no mesh files are named", "[io][meshes]") {
  const auto says = [](const fs::path& path) -> std::string {
    try {
      MeshFile::read(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const fs::path folder = scratch("mesh_folder.obj");
  for (const std::string extension :
       {".obj", ".off", ".ply", ".stl", ".vtp", ".vtu", ".bdf", ".inp", ".k"}) {
    INFO(extension);
    CHECK_THAT(says(folder / ("none" + extension)), Contains("found no such file"));
    CHECK_THAT(read_error("empty" + extension, ""),
               Contains("found an empty file, expected a mesh"));
    CHECK_THAT(read_error("blank" + extension, " \r\n\n"), Contains("found an empty file"));
    CHECK(read_error("utf16" + extension, std::string("\xFF\xFEv\0 \0\x31\0", 8)) != "no mistake");
    std::string garbage;
    std::mt19937 random(5);
    for (int i = 0; i < 5000; ++i) garbage += static_cast<char>(random() % 256);
    CHECK(read_error("garbage" + extension, garbage) != "no mistake");
    CHECK(read_error("zeros" + extension, std::string(500, '\0')) != "no mistake");
  }
  CHECK_THAT(says(folder), Contains("found a folder, expected a mesh"));
  CHECK_THAT(says(folder / "a.step"), Contains("'.step'") && Contains(".bdf"));
  CHECK_THAT(says(folder / "a"), Contains("no extension"));
}

TEST_CASE("PLY: text and binary of either byte order", "[io][meshes]") {
  const auto text = file_with("t.ply", kPly);
  const MeshFile read = MeshFile::read(text);
  CHECK(read.shells().points(0, 0) == 0.1);
  CHECK(read.shells().points(3, 2) == 0.25);
  CHECK(read.shells().points(3, 1) == 1);
  CHECK(read.warnings().size() == 2);
  for (const bool big : {false, true}) {
    const auto single = file_with("single.ply", binary_ply<float>(big));
    const auto twice = file_with("double.ply", binary_ply<double>(big));
    for (const auto& path : {single, twice}) {
      const MeshFile file = MeshFile::read(path);
      CHECK(file.shells().points(3, 2) == 0.25);
      CHECK(file.shells().face(1)[2] == 3);
      check_identity(path);
      const auto target = check_round_trip(path, moved(file, 0.3, 1), path == twice ? 0 : 1e-7);
      const std::string before = bytes_of(path), after = bytes_of(target);
      REQUIRE(before.size() == after.size());
      const size_t first = before.find("end_header\n") + 11, real = path == twice ? 8 : 4;
      for (size_t i = 0; i < before.size(); ++i)
        if (before[i] != after[i]) {
          CHECK(i > first);
          CHECK(i < first + 4 * (1 + 3 * real));
          CHECK((i - first) % (1 + 3 * real) != 0);
        }
    }
  }
  // Single precision cannot hold everything.
  const MeshFile file = MeshFile::read(file_with("big.ply", binary_ply<float>(false)));
  Points points = file.shells().points;
  points(2, 1) = 1e39;
  CHECK_THROWS_WITH(file.write(mesh_scratch() / "b.ply", points), Contains("does not fit"));
  const auto says = [](const std::string& bytes) { return read_error("e.ply", bytes); };
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
      "0\n";
  CHECK(says(head) == "13:1: found the end of the file, expected a number");
  CHECK(says(head + "2 0 1") == "13:2: found a face of 2 nodes, expected 3 or more");
  CHECK(says(head + "3 0 1 3") == "13:7: found 3 as a node number, expected 0 to 2");
  CHECK(says(head + "3 0 1 -1") == "13:7: found -1 as a node number, expected 0 to 2");
  const std::string binary = binary_ply<double>(false);
  CHECK_THAT(says(binary.substr(0, binary.size() - 40)), Contains("found the end of the file"));
  CHECK(says("ply\nformat ascii 1.0\nelement vertex x\n") ==
        "3:16: found 'x', expected a number of elements");
}

TEST_CASE("meshes whose lines end with a carriage return are read and written", "[io][meshes]") {
  for (const auto& [name, text] : {std::pair("c.obj", kObj), std::pair("c.off", kOff)}) {
    const MeshFile usual = MeshFile::read(file_with(name, text));
    std::string classic = text;
    std::replace(classic.begin(), classic.end(), '\n', '\r');
    const fs::path path = file_with(std::string("classic_") + name, classic);
    const MeshFile file = MeshFile::read(path);
    CHECK(file.shells().points == usual.shells().points);
    CHECK(same_faces(file.shells(), usual.shells()));
    check_identity(path);
  }
}

TEST_CASE("STL: corners that differ by rounding are welded, others are not", "[io][meshes]") {
  // A tube of 16 strips, whose last column is the first one, moved by a small distance.
  const auto tube = [](double shift) {
    std::ostringstream text;
    text.precision(17);
    text << "solid tube\n";
    const auto corner = [&](int k, double z) {
      const double t = 2 * M_PI * k / 16;
      text << "vertex " << (k == 16 ? 10 + shift : 10 * std::cos(t)) << " "
           << (k == 16 ? shift : 10 * std::sin(t)) << " " << z << "\n";
    };
    for (int k = 0; k < 16; ++k)
      for (const bool upper : {false, true}) {
        text << "facet normal 0 0 0\nouter loop\n";
        corner(upper ? k + 1 : k, upper ? 40 : 0);
        corner(upper ? k : k + 1, upper ? 40 : 0);
        corner(upper ? k + 1 : k, upper ? 0 : 40);
        text << "endloop\nendfacet\n";
      }
    text << "endsolid tube\n";
    return file_with("tube.stl", text.str());
  };
  for (const double shift : {0.0, 2e-15, 1e-12, 1e-9, 4e-6}) {
    const fs::path path = tube(shift);
    const MeshFile file = MeshFile::read(path);
    CHECK(file.shells().node_count() == 32);
    CHECK(file.warnings().size() == (shift > 0 ? 1 : 0));
    check_identity(path);
    // Corners of a node that moves stay together.
    CHECK(MeshFile::read(check_round_trip(path, moved(file, 0.3, 1), 0)).shells().node_count() ==
          32);
  }
  for (const double shift : {2e-5, 1e-3})
    CHECK(MeshFile::read(tube(shift)).shells().node_count() == 34);
}

TEST_CASE("STL: corners become nodes, normals follow", "[io][meshes]") {
  const MeshFile file = MeshFile::read(file_with("t.stl", kStl));
  CHECK(file.format() == "STL text");
  REQUIRE(file.shells().node_count() == 4);
  REQUIRE(file.shells().face_count() == 2);
  REQUIRE(file.sets().size() == 2);
  CHECK(file.sets()[1].faces == std::vector<int>{1});
  Points points = file.shells().points;
  points.col(2) = points.col(1);  // tilted by 45°
  const auto target = mesh_scratch() / "turned.stl";
  CHECK(file.write(target, points).largest == 0);
  const std::string text = bytes_of(target);
  CHECK_THAT(text, Contains("facet normal 0 -0.70710677 0.70710677\n"));
  CHECK_THAT(text, Contains("vertex 1.00 0 0\n") && Contains("endsolid two"));
  // The binary file made from it has the same nodes; attribute bytes and header are unchanged.
  ShellMesh mesh = MeshFile::read(target).shells();
  const auto binary = mesh_scratch() / "b.stl";
  write_mesh(binary, mesh);
  std::string bytes = bytes_of(binary);
  REQUIRE(bytes.size() == 84 + 2 * 50);
  bytes.replace(0, 5, "solid");
  bytes[84 + 48] = 'A';
  const auto marked = file_with("marked.stl", bytes);
  const MeshFile again = MeshFile::read(marked);
  CHECK(again.format() == "binary STL");
  CHECK(again.shells().points == mesh.points);
  CHECK(same_faces(again.shells(), mesh));
  check_identity(marked);
  const std::string after = bytes_of(check_round_trip(marked, moved(again, 0.3, 1), 1e-7));
  CHECK(after.substr(0, 84) == bytes.substr(0, 84));
  CHECK(after[84 + 48] == 'A');
  CHECK_THAT(read_error("short.stl", bytes.substr(0, 150)), Contains("found"));
  CHECK(read_error("e.stl", "solid\nfacet normal 0 0 1\nvertex 0 0 0\nendfacet\n") ==
        "4:1: found 'endfacet' after 1 corner, expected facets of three");
  CHECK(read_error("e.stl", "solid\nfacet\nvertex 0 0 x\n") ==
        "3:12: found 'x', expected a number");
  std::string infinite = bytes;
  put(infinite, std::numeric_limits<float>::infinity(), false);
  infinite.replace(84 + 12, 4, infinite.substr(infinite.size() - 4));
  infinite.resize(bytes.size());
  CHECK_THAT(read_error("inf.stl", infinite), Contains("triangle 0 is not finite"));
}

TEST_CASE("a mesh is the same in every format that can hold it", "[io][meshes]") {
  const ShellMesh mesh = mixed_mesh();
  for (const std::string extension : {".obj", ".off", ".ply", ".vtp", ".vtu"}) {
    INFO(extension);
    const auto path = mesh_scratch() / ("mixed" + extension);
    write_mesh(path, mesh);
    const MeshFile file = MeshFile::read(path);
    CHECK(file.shells().points == mesh.points);
    REQUIRE(file.shells().face_count() == mesh.face_count());
    if (extension == ".vtu") {
      CHECK(same_faces(file.shells(), mesh));
    } else {
      const auto face = file.shells().face(2);
      CHECK(std::vector<int>(face.begin(), face.end()) == std::vector<int>{3, 6, 5, 7, 4, 8});
    }
    check_round_trip(path, moved(file), 0);
    if (extension != ".vtp" && extension != ".vtu") check_identity(path);
  }
  // STL: the area of flat faces does not depend on their triangulation.
  ShellMesh flat;
  flat.points.resize(8, 3);
  flat.points << 0, 0, 0, 4, 0, 0, 4, 2, 0, 0, 2, 0, 2, 0, 0, 4, 1, 0, 2, 2, 0, 0, 1, 0;
  flat.add_face(std::array{0, 1, 2, 3, 4, 5, 6, 7}, true);
  flat.add_face(std::array{0, 1, 2, 3});
  flat.add_face(std::array{0, 4, 1, 5, 2, 6, 3, 7});
  flat.add_face(std::array{0, 1, 3, 4, 6, 7}, true);
  const auto path = mesh_scratch() / "flat.stl";
  write_mesh(path, flat);
  const MeshFile stl = MeshFile::read(path);
  double area = 0;
  for (int f = 0; f < stl.shells().face_count(); ++f) {
    const auto n = stl.shells().face(f);
    const Points& p = stl.shells().points;
    const Vec3 a = p.row(n[0]), b = p.row(n[1]), c = p.row(n[2]);
    area += (b - a).cross(c - a).z() / 2;
  }
  CHECK(area == Approx(3 * 8 + 4 + 2));  // the last one's mid-side nodes protrude
}

TEST_CASE("write_mesh refuses invalid meshes", "[io][meshes]") {
  ShellMesh mesh = mixed_mesh();
  CHECK_THROWS_WITH(write_mesh(mesh_scratch() / "a.k", mesh), Contains("'.k'"));
  ShellMesh two = mesh;
  two.add_face(std::array{0, 1});
  CHECK_THROWS_WITH(write_mesh(mesh_scratch() / "a.obj", two), Contains("face 5 has 2 nodes"));
  ShellMesh far = mesh;
  far.add_face(std::array{0, 1, 17});
  CHECK_THROWS_WITH(write_mesh(mesh_scratch() / "a.vtu", far),
                    Contains("node 17, expected 0 to 16"));
  mesh.points(3, 1) = NAN;
  CHECK_THROWS_WITH(write_mesh(mesh_scratch() / "a.ply", mesh), Contains("node 3 is not finite"));
  CHECK_FALSE(fs::exists(mesh_scratch() / "a.obj"));
}

TEST_CASE("VTK reads the files as they are meant", "[io][meshes]") {
  if (!have_python_with("vtk")) return;
  const ShellMesh mesh = mixed_mesh();
  for (const std::string extension : {".obj", ".ply", ".vtp", ".vtu"}) {
    const auto path = mesh_scratch() / ("vtk" + extension);
    write_mesh(path, mesh);
    const double single = extension == ".obj" || extension == ".ply" ? 1e-6 : 0;
    check_positions(path, mesh.points, single);
    const MeshFile file = MeshFile::read(path);
    const Points points = moved(file);
    file.write(path, points);
    check_positions(path, points, single);
  }
  for (const std::string& bytes : {kStl, std::string()}) {
    const auto path = file_with("vtk.stl", bytes);
    if (bytes.empty()) write_mesh(path, mesh);
    const MeshFile file = MeshFile::read(path);
    const Points points = moved(file);
    file.write(path, points);
    Points corners(3 * file.shells().face_count(), 3);
    for (int f = 0; f < file.shells().face_count(); ++f)
      for (int k = 0; k < 3; ++k) corners.row(3 * f + k) = points.row(file.shells().face(f)[k]);
    check_positions(path, corners, 1e-6);
  }
  for (const bool big : {false, true}) {
    const auto path = file_with("vtk_binary.ply", binary_ply<float>(big));
    const MeshFile file = MeshFile::read(path);
    const Points points = moved(file);
    file.write(path, points);
    check_positions(path, points, 1e-6);
  }
}

TEST_CASE("VTP and VTU: other cells and data stay, normals go", "[io][meshes]") {
  const std::string points =
      "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">"
      "0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0</DataArray></Points>";
  const std::string data =
      "<PointData Scalars=\"t\" Normals=\"Normals\"><DataArray type=\"Float64\" Name=\"t\" "
      "format=\"ascii\">1 2 3 4 5 6</DataArray><DataArray type=\"Float32\" Name=\"Normals\" "
      "NumberOfComponents=\"3\" format=\"ascii\">0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1</DataArray>"
      "</PointData><CellData><DataArray type=\"Int32\" Name=\"pid\" format=\"ascii\">7 8 9"
      "</DataArray></CellData>";
  const auto cells = [](const std::string& nodes, const std::string& offsets) {
    return "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" + nodes +
           "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" + offsets +
           "</DataArray>";
  };
  const std::string vtp =
      "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"0.1\" "
      "byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"6\" NumberOfVerts=\"0\" "
      "NumberOfLines=\"1\" NumberOfStrips=\"1\" NumberOfPolys=\"1\">" +
      data + points + "<Lines>" + cells("0 4", "2") + "</Lines><Polys>" + cells("0 1 2 3", "4") +
      "</Polys><Strips>" + cells("1 4 2 5", "4") + "</Strips></Piece></PolyData></VTKFile>";
  const std::string vtu =
      "<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
      "byte_order=\"LittleEndian\"><UnstructuredGrid><Piece NumberOfPoints=\"6\" "
      "NumberOfCells=\"3\">" +
      data + points + "<Cells>" + cells("0 4 0 1 3 2 1 4 2", "2 6 9") +
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">3 8 5</DataArray></Cells></Piece>"
      "</UnstructuredGrid></VTKFile>";
  for (const bool surface : {true, false}) {
    const auto path = file_with(surface ? "x.vtp" : "x.vtu", surface ? vtp : vtu);
    const MeshFile file = MeshFile::read(path);
    REQUIRE(file.shells().face_count() == (surface ? 3 : 2));
    // The two triangles of the strip are one cell: faces are numbered then, not cells.
    const int first = surface ? 0 : 1;
    CHECK(file.face_label(0) == first);
    const auto face = file.shells().face(0);
    CHECK(std::vector<int>(face.begin(), face.end()) == std::vector<int>{0, 1, 2, 3});
    REQUIRE(file.warnings().size() == 1);
    CHECK_THAT(file.warnings()[0], Contains("vtk") && Contains("cells move with their nodes"));
    const auto copy = mesh_scratch() / (surface ? "notes.vtp" : "notes.vtu");
    CHECK(file.write(copy, file.shells().points).notes.empty());
    const std::vector<std::string> notes = file.write(copy, moved(file, 0.3, 1)).notes;
    REQUIRE(notes.size() == 1);
    CHECK_THAT(notes[0], Contains("point normals 'Normals' are not written"));
    const MeshFile again = MeshFile::read(check_round_trip(path, moved(file, 0.3, 1), 0));
    CHECK(again.warnings().size() == 1);
    CHECK(again.face_label(0) == first);
    std::string text = bytes_of(mesh_scratch() / (surface ? "moved_x.vtp" : "moved_x.vtu"));
    CHECK_THAT(text, Contains("Name=\"t\"") && Contains("Name=\"pid\""));
    // Cells that refer to missing nodes.
    std::string broken = surface ? vtp : vtu;
    broken.replace(broken.find("0 4"), 3, "0 6");
    CHECK_THAT(read_error(surface ? "n.vtp" : "n.vtu", broken), Contains("found node number 6"));
    CHECK_THAT(read_error(surface ? "n.vtu" : "n.vtp", surface ? vtp : vtu),
               Contains("VTK cannot read"));
    check_damage(surface ? ".vtp" : ".vtu", surface ? vtp : vtu, 300, false);
  }
}

TEST_CASE("damaged mesh files give a result or an error", "[io][meshes]") {
  const DeferredFlush deferred;  // thousands of files
  check_damage(".obj", kObj, 1500);
  check_damage(".off", kOff, 1500);
  check_damage(".stl", kStl, 1500);
  check_damage(".ply", kPly, 1500);
  check_damage(".ply", binary_ply<float>(true), 1500);
  check_damage(".ply", binary_ply<double>(false), 1500);
  write_mesh(mesh_scratch() / "damage.stl", mixed_mesh());
  check_damage(".stl", bytes_of(mesh_scratch() / "damage.stl"), 500);
}

TEST_CASE("real meshes come back as they were", "[io][meshes]") {
  int found = 0;
  for (const std::string name :
       {"panel-neon-side/neon_side.off", "panel-bottle-support/W1000BO_pid_1_a_tri.obj",
        "meshes-cgal/mech-holes-shark.off", "meshes-pmp/fandisk_quads.off",
        "meshes-geometry-central/spot.ply", "meshes-geometry-central/fox.ply",
        "meshes-geometry-central/moebius.obj", "cage-opensubdiv-car/catmark_car.obj"}) {
    const fs::path path = optional_data(name);
    if (path.empty()) continue;
    ++found;
    check_identity(path);
    const MeshFile file = MeshFile::read(path);
    const bool single = name.ends_with(".ply");
    check_round_trip(path, moved(file, 0.01, 2), single ? 1e-5 : 0);
  }
  if (found == 0) WARN("no real meshes beside the project: nothing was read");
}
