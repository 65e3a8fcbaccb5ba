// SPDX-License-Identifier: MPL-2.0
// Results of CalculiX as sequences: boundary surfaces of all its elements.
#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "batten/io/decks/frd_results.h"
#include "batten/tests/io/sequences/sequence_file_helpers.h"
#include "batten/tests/support/calculix_decks.h"

using namespace batten_test;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Two tetrahedra with a shared face, two steps; columns as ccx writes them.
const std::string kHead =
    "    1C\n"
    "    2C                             5                                     1\n"
    " -1         1 0.00000E+00 0.00000E+00 0.00000E+00\n"
    " -1         2 1.00000E+00 0.00000E+00 0.00000E+00\n"
    " -1         3 0.00000E+00 1.00000E+00 0.00000E+00\n"
    " -1         7 0.00000E+00 0.00000E+00 1.00000E+00\n"
    " -1         9 0.00000E+00 0.00000E+00-1.00000E+00\n"
    " -3\n"
    "    3C                             2                                     1\n"
    " -1         1    3    0    1\n"
    " -2         1         2         3         7\n"
    " -1         2    3    0    1\n"
    " -2         1         3         2         9\n"
    " -3\n";

std::string step(const std::string& value, const std::string& up) {
  return "    1PSTEP                         1           1           1\n"
         "  100CL  101 " +
         value +
         "           5                     0    1           1\n"
         " -4  DISP        4    1\n"
         " -5  D1          1    2    1    0\n"
         " -1         7 0.00000E+00 0.00000E+00 " +
         up +
         "\n"
         " -3\n";
}

/// The same text in the short format: format 0, node and element numbers of five columns.
std::string shortened(const std::string& text) {
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("    2C") || line.starts_with("    3C") || line.starts_with("  100C"))
      line.back() = '0';
    if (line.starts_with(" -1")) line.erase(3, 5);
    if (line.starts_with(" -2"))
      for (size_t at = 3; at < line.size(); at += 5) line.erase(at, 5);
    result += line + '\n';
  }
  return result;
}

/// Enclosed volume of a surface of triangles and quads, ignoring mid-side nodes.
double volume(const ShellMesh& mesh, const Points& p) {
  double six = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto c = mesh.corners(f);
    for (size_t i = 2; i < c.size(); ++i)
      six += Vec3(p.row(c[0])).dot(Vec3(p.row(c[i - 1])).cross(Vec3(p.row(c[i]))));
  }
  return six / 6;
}

/// One element of each type, as a deck: corner nodes, then mid-side nodes of the listed edges.
struct Kind {
  std::string name;
  std::vector<Vec3> corners;
  std::vector<std::array<int, 2>> middles;
  int faces;
  double volume;
};

std::vector<Kind> kinds() {
  const std::vector<Vec3> tetrahedron{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
      wedge{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
      box{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
      square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  return {{"C3D4", tetrahedron, {}, 4, 1. / 6},
          {"C3D10", tetrahedron, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}, 4, 1. / 6},
          {"C3D6", wedge, {}, 5, 0.5},
          {"C3D15",
           wedge,
           {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
           5,
           0.5},
          {"C3D8", box, {}, 6, 1},
          {"C3D20",
           box,
           {{0, 1},
            {1, 2},
            {2, 3},
            {3, 0},
            {4, 5},
            {5, 6},
            {6, 7},
            {7, 4},
            {0, 4},
            {1, 5},
            {2, 6},
            {3, 7}},
           6,
           1},
          {"S4", square, {}, 6, 0.5},
          {"S8", square, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, 6, 0.5}};
}

/// Stretched along x by a tenth, then by two tenths, with all corners prescribed.
std::string deck_of(const Kind& kind) {
  std::string deck = "*NODE, NSET=ALL\n";
  int label = 0;
  const auto node = [&](const Vec3& p) {
    deck += std::to_string(++label) + "," + std::to_string(p[0]) + "," + std::to_string(p[1]) +
            "," + std::to_string(p[2]) + "\n";
  };
  for (const Vec3& p : kind.corners) node(p);
  for (const auto& [a, b] : kind.middles) node((kind.corners[a] + kind.corners[b]) / 2);
  deck += "*ELEMENT, TYPE=" + kind.name + ", ELSET=E\n1";
  for (int i = 1; i <= label; ++i) deck += (i % 12 == 0 ? ",\n" : ",") + std::to_string(i);
  const bool shell = kind.name[0] == 'S';
  deck += "\n*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.\n";
  deck += shell ? "*SHELL SECTION, ELSET=E, MATERIAL=M\n0.5\n"
                : "*SOLID SECTION, ELSET=E, MATERIAL=M\n";
  for (const std::string amount : {"0.1", "0.2"}) {
    deck += "*STEP\n*STATIC\n*BOUNDARY\n";
    for (int i = 1; i <= isize(kind.corners); ++i) {
      const double x = kind.corners[i - 1][0];
      deck += std::to_string(i) + ",1,1," + (x > 0.5 ? amount : "0.") + "\n" + std::to_string(i) +
              ",2,3,0.\n";
    }
    deck += "*NODE FILE\nU\n*END STEP\n";
  }
  return deck;
}

}  // namespace

TEST_CASE("results are frames of their skin", "[io][sequences]") {
  const fs::path folder = scratch("frd_sequence/steps"), file = folder / "a.frd";
  put_bytes(file, kHead + step("5.00000E-01", "1.00000E+00") + step("1.00000E+00", "2.50000E+00") +
                      " 9999\n");
  const MeshSequence s = read_frames(file);
  CHECK(s.times == std::vector<double>{0.5, 1});
  CHECK(s.node_count() == 5);
  CHECK(s.shells.face_count() == 6);  // the shared face is inside
  CHECK(s.frames[0](3, 2) == 2);
  CHECK(s.frames[1](3, 2) == 3.5);
  CHECK(s.frames[1](4, 2) == -1);
  CHECK(volume(s.shells, s.frames[1]) == Approx((3.5 + 1) / 6));
  SequenceOptions second;
  second.first = 2;
  CHECK(read_frames(file, second).times == std::vector<double>{1});
  second.first = 3;
  CHECK_THAT(reading(file, second),
             Contains("a.frd: found 2 frames, expected frames 3 to the end"));
  put_bytes(file, shortened(kHead + step("5.00000E-01", "1.00000E+00") +
                            step("1.00000E+00", "2.50000E+00")));
  const MeshSequence in_short = read_frames(file);
  CHECK(in_short.times == s.times);
  CHECK(in_short.frames[1] == s.frames[1]);
  CHECK(volume(in_short.shells, in_short.frames[1]) == Approx((3.5 + 1) / 6));
  // Modes with one frequency.
  put_bytes(file, kHead + step("3.00000E+00", "1.00000E+00") + step("3.00000E+00", "2.00000E+00"));
  CHECK(read_frames(file).times == std::vector<double>{1, 2});
  // The results of the last step are unchanged.
  CHECK(read_frd(file).nodes[3].displacement == Vec3(0, 0, 2));
}

TEST_CASE("damaged results are refused with their line", "[io][sequences]") {
  const fs::path file = scratch("frd_sequence/damaged") / "a.frd";
  const auto refused = [&](const std::string& text) {
    put_bytes(file, text);
    return reading(file);
  };
  const std::string up = step("1.00000E+00", "1.00000E+00");
  CHECK_THAT(refused(kHead), Contains("a.frd: found no displacements"));
  CHECK_THAT(refused(kHead + up.substr(0, up.size() - 4)),
             Contains("found the end of the file, expected the end of a block"));
  CHECK_THAT(refused(kHead + up.substr(0, up.size() - 12)),
             Contains("a.frd:19:1: found a short line"));
  const auto changed = [&](const std::string& what, const std::string& with) {
    std::string text = kHead + up;
    text.replace(text.find(what), what.size(), with);
    return refused(text);
  };
  CHECK_THAT(changed(" -2         1         2         3         7",
                     " -2         1         2         3         8"),
             Contains("a.frd:11:1: found node 8, expected one of the nodes"));
  CHECK_THAT(
      changed(" -2         1         2         3         7", " -2         1         2         3"),
      Contains("a.frd: element 1 has 3 nodes, expected 4"));
  CHECK_THAT(
      changed(" -1         7 0.00000E+00 0.00000E+00 1", " -1         7 x.00000E+00 0.00000E+00 1"),
      Contains("found 'x.00000E+00', expected a number"));
  CHECK_THAT(changed("                                     1\n -1         1 0",
                     "                                     2\n -1         1 0"),
             Contains("a.frd:2:1: found a binary block, expected text"));
  std::string beam = kHead + up;
  for (const std::string head : {" -1         1    3", " -1         2    3"})
    beam.replace(beam.find(head), head.size(), head.substr(0, 17) + "1");
  for (size_t at = beam.find("   1    0    1"); at != beam.npos;
       at = beam.find("   1    0    1", at))
    beam.replace(at, 4, "  11");
  CHECK_THAT(refused(beam), Contains("found no solids or shells with faces"));
}

TEST_CASE("ccx' own results have closed skins, whatever the element", "[io][sequences]") {
  if (!have_ccx()) return;
  const fs::path folder = scratch("frd_sequence/ccx");
  for (const Kind& kind : kinds()) {
    INFO(kind.name);
    put_bytes(folder / (kind.name + ".inp"), deck_of(kind));
    REQUIRE(std::system(
                ("cd '" + folder.string() + "' && ccx " + kind.name + " > log 2>&1").c_str()) == 0);
    const MeshSequence s = read_frames(folder / (kind.name + ".frd"));
    REQUIRE(s.frame_count() == 2);
    CHECK(s.times == std::vector<double>{1, 2});
    CHECK(s.shells.face_count() == kind.faces);
    CHECK(volume(s.shells, s.frames[0]) == Approx(1.1 * kind.volume).epsilon(1e-4));
    CHECK(volume(s.shells, s.frames[1]) == Approx(1.2 * kind.volume).epsilon(1e-4));
    // Every edge once in each direction, every mid-side node in the middle of its edge.
    std::map<std::array<int, 2>, int> edges;
    for (int f = 0; f < s.shells.face_count(); ++f) {
      const auto corners = s.shells.corners(f), nodes = s.shells.face(f);
      for (size_t i = 0; i < corners.size(); ++i) {
        const int a = corners[i], b = corners[(i + 1) % corners.size()];
        CHECK(++edges[{a, b}] == 1);
        if (s.shells.second_order(f))
          CHECK((s.frames[1].row(nodes[corners.size() + i]) -
                 (s.frames[1].row(a) + s.frames[1].row(b)) / 2)
                    .norm() < 0.2);
      }
    }
    for (const auto& [edge, count] : edges) CHECK(edges.count({edge[1], edge[0]}) == 1);
  }
}
